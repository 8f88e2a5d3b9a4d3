// What a program is told by the one that started it.
#pragma once

#include <string>

#include <takt/os/fd.hpp>

namespace takt::os {

/// The descriptor whose number an environment variable holds; it is closed on the next exec and the variable
/// is removed, so that this program's own children do not get it. Empty when there is none.
Fd take_fd_from_environment(const char* name);

/// The value of an environment variable; empty when it is not set.
std::string environment(const char* name);

/// Lifts this process's limit on open descriptors to what it may have.
void raise_descriptor_limit();

}  // namespace takt::os
