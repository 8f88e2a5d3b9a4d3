// The environment of a program: variables, arguments, inherited descriptors and resource limits, and the name
// of its machine.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// Takes over the descriptor whose number is in an environment variable. Removes the variable and marks the
/// descriptor close-on-exec, so that programs that this program starts do not inherit it. The result is empty
/// if there is no such descriptor.
Fd take_fd_from_environment(const char* name);

/// Takes over a descriptor with a known number and marks it close-on-exec. The result is empty if no
/// descriptor has this number.
Fd adopt_fd(int number);

/// Returns and removes an environment variable; empty if it is not set.
std::string take_from_environment(const char* name);

/// The value of an environment variable; empty if it is not set.
std::string environment(const char* name);
/// Sets an environment variable for this program and for programs that it starts. May be called only while
/// this program has a single thread.
void set_environment(const char* name, const std::string& value);

/// The arguments of this program, without the program's name. May be called only after the C library has been
/// initialized.
std::vector<std::string> program_arguments();

/// The name of this machine.
std::string host_name();
int process_id();
/// Returns true if this program runs as root.
bool is_root();

/// Raises the limit of this process on open descriptors to the hard limit.
void raise_descriptor_limit();
/// Checks that this process can open this many additional descriptors, and fails if it cannot.
Result<void> can_open(std::size_t descriptors);

/// Identifies the time since this machine was booted; the id changes at each boot. CLOCK_MONOTONIC values are
/// comparable only within one boot. Empty if the system does not provide the id.
std::string boot_id();

}  // namespace takt::os
