// Whether what the calling thread does counts just now, and where it is written down.
#pragma once

#include <cstdint>

#include <takt/channel/violations.hpp>

namespace takt::check {

/// Whether the calling thread is in a module, and not in what this library does for it.
bool counts() noexcept;

/// Nothing that the calling thread does counts while this lives.
class Pause {
 public:
  Pause() noexcept;
  ~Pause();
  Pause(const Pause&) = delete;
  Pause& operator=(const Pause&) = delete;
  /// It goes on after the end of this, until the thread enters a module again.
  void goes_on() noexcept { before_ = 0; }

 private:
  char before_;
};

/// What the thread just did, with the calls that led there. Only while it counts, with a Pause.
struct Deed {
  channel::ViolationKind kind = channel::ViolationKind::allocation;
  const char* function = "";
  std::int64_t system_call = 0;
  std::uint64_t times = 1;
  bool exact = false;  ///< the innermost place is an instruction, not what a call returns to
  bool placed = true;  ///< the calls that led here are those that led to it
};
void record(const Deed& deed) noexcept;

/// Something that this machine does not show.
void is_blind(std::uint32_t bit) noexcept;

/// The byte that tells the kernel, too, whether the calling thread's system calls count.
char* selector() noexcept;

}  // namespace takt::check
