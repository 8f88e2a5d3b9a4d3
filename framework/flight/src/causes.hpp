// Finds out why rows and runs began late, as a pure function of a recording.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/flight/recording.hpp>
#include "timeline.hpp"

namespace takt::flight {

enum class Cause {
  own_overrun,  ///< the executor's previous row took too long
  predecessor,  ///< a module before it in its row took too long
  wake_up,      ///< the thread was woken late, and nothing else is known
  preemption,   ///< another thread had its CPU, or its process was stopped
  page_fault,   ///< the kernel mapped memory for it
  hypervisor,   ///< another virtual machine had its CPU (steal)
  unknown,      ///< there are no samples of that time
};
inline constexpr std::array<Cause, 7> kCauses{Cause::own_overrun, Cause::predecessor, Cause::wake_up,
                                              Cause::preemption,  Cause::page_fault,  Cause::hypervisor,
                                              Cause::unknown};
/// "own overrun", "predecessor", "wake-up", ...
const char* to_text(Cause cause) noexcept;

/// What the kernel counted in a window beyond the usual. The window extends to the samples before and after.
struct Evidence {
  bool looked = false;         ///< there are samples before and after
  Nanoseconds waited{};        ///< for a CPU
  std::uint64_t gave_way = 0;  ///< times it was preempted
  std::uint64_t minor_faults = 0;
  std::uint64_t major_faults = 0;
  Nanoseconds stolen{};  ///< from its CPU
  bool stopped = false;
};

struct LateStart {
  std::optional<std::size_t> run;  ///< index in the timeline's runs; none: the row itself
  std::size_t row = 0;
  std::int64_t due_ns = 0;  ///< for a row its release, or that of the first missed row before it; for a run
                            ///< the time at which it usually begins in its row
  Nanoseconds late{};
  std::uint64_t missed = 0;  ///< missed rows before it
  Cause cause = Cause::unknown;
  std::optional<std::uint32_t> culprit{};  ///< the module that took too long
  Nanoseconds took{};                      ///< the culprit's run time
  Nanoseconds usual{};                     ///< its usual run time
  Evidence evidence{};
};

/// Usual values, and the limit above which a start counts as late.
struct Usual {
  Nanoseconds threshold{};  ///< the greater of 20 us and ten times the median lateness; at most half a basic
                            ///< period, but never less than 20 us
  Nanoseconds row{};        ///< the median duration of a row
};
Usual usual_of(const Timeline& line, Nanoseconds basic_period);

/// What was counted for a thread between two instants. `thread`: 0 for rows, 1 for sporadic modules.
Evidence evidence_between(const std::vector<Sample>& samples, std::size_t executor, std::size_t thread,
                          std::int64_t from_ns, std::int64_t to_ns);

/// Every late start in the rows of an executor, in order. The greatest of the kernel's counts is the cause if
/// it accounts for half of the delay. Otherwise the cause is the previous row, else the wake-up.
std::vector<LateStart> late_starts(const Recording& recording, std::size_t executor, const Timeline& line);

/// With three digits: "3.21 ms".
std::string in_short(Nanoseconds duration);
/// "servo ran 3.21 ms in the row before (usually 41 us); 812 page faults"
std::string in_words(const LateStart& late, const std::vector<Module>& modules);

}  // namespace takt::flight
