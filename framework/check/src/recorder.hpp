// Records the violations of the calling thread while it runs a module.
#pragma once

#include <cstdint>

#include <takt/channel/violations.hpp>

namespace takt::check {

/// Returns true if the library must record violations of the calling thread now. This is so if the thread is
/// in the code of a module, and not in the library's own code.
bool counts() noexcept;

/// While this object exists, the library records no violation of the calling thread, and counts() returns
/// false.
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

/// A violation of the calling thread. Call record() only if counts() has returned true, and only while a
/// Pause exists.
struct Occurrence {
  channel::ViolationKind kind = channel::ViolationKind::allocation;
  const char* function = "";
  std::int64_t system_call = 0;
  std::uint64_t times = 1;
  bool exact = false;  ///< true: the innermost address is the instruction itself, not a return address
  bool placed = true;  ///< false: the present call stack did not cause the violation, so the stack is not
                       ///< recorded
};
void record(const Occurrence& occurrence) noexcept;

/// Stores in the log that this machine cannot detect a kind of violation. `bit`: ViolationLog::kNoSystemCalls
/// or kNoFaultPlaces.
void is_blind(std::uint32_t bit) noexcept;

/// Returns the address of the calling thread's selector byte. The kernel reads this byte to decide whether it
/// intercepts the thread's system calls.
char* selector() noexcept;

}  // namespace takt::check
