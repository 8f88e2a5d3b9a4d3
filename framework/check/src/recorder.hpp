// Records the violations of the calling thread while it runs a module.
#pragma once

#include <cstdint>

#include <takt/channel/violations.hpp>

namespace takt::check {

/// Whether violations of the calling thread count. They count if the thread is in a module and not in this
/// library's own code.
bool counts() noexcept;

/// While this object exists, no violation of the calling thread counts.
class Pause {
 public:
  Pause() noexcept;
  ~Pause();
  Pause(const Pause&) = delete;
  Pause& operator=(const Pause&) = delete;
  /// Extends the pause beyond this object, until the thread enters a module again.
  void goes_on() noexcept { before_ = 0; }

 private:
  char before_;
};

/// A violation of the calling thread. Record it only if counts() returns true, and only while a Pause exists.
struct Occurrence {
  channel::ViolationKind kind = channel::ViolationKind::allocation;
  const char* function = "";
  std::int64_t system_call = 0;
  std::uint64_t times = 1;
  bool exact = false;  ///< the innermost address is that of the instruction, not a return address
  bool placed = true;  ///< whether the present call stack is that of the violation
};
void record(const Occurrence& occurrence) noexcept;

/// Notes that this machine cannot detect a kind of violation.
void is_blind(std::uint32_t bit) noexcept;

/// The byte from which the kernel reads whether the calling thread's system calls count.
char* selector() noexcept;

}  // namespace takt::check
