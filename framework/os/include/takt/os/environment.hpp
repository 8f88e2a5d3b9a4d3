// The environment of this process: variables, arguments, inherited file descriptors, resource limits and heaps,
// and the name of its machine.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// Takes over the file descriptor whose number is in an environment variable. Removes the variable, and marks
/// the descriptor close-on-exec, so that child processes do not inherit it. The result is empty if there is
/// no such variable or descriptor.
Fd take_fd_from_environment(const char* name);

/// Takes over the file descriptor with this number, and marks it close-on-exec. The result is empty if no
/// open descriptor has this number.
Fd adopt_fd(int number);

/// Returns the value of an environment variable, and removes the variable; empty if it is not set.
std::string take_from_environment(const char* name);

/// Returns the value of an environment variable; empty if it is not set.
std::string environment(const char* name);
/// Sets an environment variable for this process and for its later child processes. Call it only while this
/// process has a single thread.
void set_environment(const char* name, const std::string& value);

/// While this object exists, this process has the variable `added` ("NAME=value", a literal), and none whose
/// name begins with one of `hidden`. Meanwhile, other threads may read the environment, but not change it.
/// There is at most one such object.
class ChangedEnvironment {
 public:
  ChangedEnvironment(std::initializer_list<std::string_view> hidden, const char* added);
  ChangedEnvironment(const ChangedEnvironment&) = delete;
  ChangedEnvironment& operator=(const ChangedEnvironment&) = delete;
  ~ChangedEnvironment();

 private:
  char** const before_;
};

/// Lets the threads of this process share two heaps. By default there are up to eight for each CPU, and each keeps
/// the memory that its threads have needed at most: in a node, that of the largest text. Call it before the process
/// starts threads.
void share_heaps() noexcept;

/// Returns the arguments of this program, without the program's name.
std::vector<std::string> program_arguments();

/// Returns the name of this machine; "localhost" if it cannot be read.
std::string host_name();
int process_id();
/// Returns the name of a user, by default of the one who runs this program; the user's number if there is no
/// name.
std::string user_name();
std::string user_name(unsigned user);
/// Returns true if this program runs as root.
bool is_root();

/// Raises this process's limit on open file descriptors as far as the system allows (to the hard limit).
void raise_descriptor_limit();
/// Fails if this process cannot open this many file descriptors in addition to those that are open.
Result<void> can_open(std::size_t descriptors);

/// Returns an id that is different after each boot of this machine; empty if the system does not provide it.
/// Times of CLOCK_MONOTONIC are comparable only if they have the same boot id.
std::string boot_id();

}  // namespace takt::os
