// The environment of a program: variables, arguments, inherited descriptors, limits and the names of the
// machine.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// Takes the descriptor whose number is in an environment variable. Removes the variable and marks the
/// descriptor to close on exec, so that children of this program do not get it. Empty if there is no such
/// descriptor.
Fd take_fd_from_environment(const char* name);

/// Takes a descriptor with a known number and marks it to close on exec. Empty if the number is not a
/// descriptor.
Fd adopt_fd(int number);

/// Returns and removes an environment variable; empty if it is not set.
std::string take_from_environment(const char* name);

/// The value of an environment variable; empty if it is not set.
std::string environment(const char* name);
/// Sets an environment variable for this program and the programs that it starts. Call it only while there is
/// a single thread.
void set_environment(const char* name, const std::string& value);

/// The arguments of this program, without its own name. Call it only after the C library is initialized.
std::vector<std::string> program_arguments();

/// The name of this machine.
std::string host_name();
int process_id();
/// Whether this program runs as root.
bool is_root();

/// Raises this process's limit on open descriptors to its hard limit.
void raise_descriptor_limit();
/// Fails if this process cannot open this many more descriptors.
Result<void> can_open(std::size_t descriptors);

/// The id of the present boot of this machine. It changes when the kernel starts again; until then
/// CLOCK_MONOTONIC continues. Empty if the system does not provide it.
std::string boot_id();

}  // namespace takt::os
