// What a program is told by the one that started it, and who and where it is.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// The descriptor whose number an environment variable holds; it is closed on the next exec and the variable
/// is removed, so that this program's own children do not get it. Empty when there is none.
Fd take_fd_from_environment(const char* name);

/// The same for a descriptor whose number is known; empty when it is none.
Fd adopt_fd(int number);

/// The value of an environment variable, which is removed; empty when it is not set.
std::string take_from_environment(const char* name);

/// The value of an environment variable; empty when it is not set.
std::string environment(const char* name);
/// For this program and those that it starts. While there is one thread.
void set_environment(const char* name, const std::string& value);

/// What this program was started with, without its own name. Not before the C library is there.
std::vector<std::string> program_arguments();

/// The name of this machine.
std::string host_name();
int process_id();
/// Whether this program may do everything.
bool is_root();

/// Lifts this process's limit on open descriptors to what it may have.
void raise_descriptor_limit();
/// Fails where this process cannot open so many more.
Result<void> can_open(std::size_t descriptors);

/// Of this machine since it was switched on: another one after each start of its kernel, until which
/// CLOCK_MONOTONIC goes on. Empty where the system does not say.
std::string boot_id();

}  // namespace takt::os
