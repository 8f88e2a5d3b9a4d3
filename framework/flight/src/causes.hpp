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
  predecessor,  ///< a module earlier in the row took too long
  wake_up,      ///< the thread was woken late, and no other cause is known
  preemption,   ///< another thread used the CPU, or the process was stopped
  page_fault,   ///< the kernel mapped memory for the thread
  hypervisor,   ///< another virtual machine used the CPU (steal time)
  unknown,      ///< there are no samples of that time
};
inline constexpr std::array<Cause, 7> kCauses{Cause::own_overrun, Cause::predecessor, Cause::wake_up,
                                              Cause::preemption,  Cause::page_fault,  Cause::hypervisor,
                                              Cause::unknown};
/// The name of a cause, such as "own overrun" or "wake-up".
const char* to_text(Cause cause) noexcept;

/// What the kernel counted for a thread in a window of time, above the usual amount. The window begins with
/// the sample before the delay and ends with the sample after it.
struct Evidence {
  bool looked = false;         ///< whether there are samples before and after the delay
  Nanoseconds waited{};        ///< time spent waiting for a CPU
  std::uint64_t gave_way = 0;  ///< number of preemptions
  std::uint64_t minor_faults = 0;
  std::uint64_t major_faults = 0;
  Nanoseconds stolen{};  ///< time stolen from the CPU
  bool stopped = false;
};

struct LateStart {
  std::optional<std::size_t> run;  ///< index in the timeline's runs; empty if the row itself began late
  std::size_t row = 0;
  /// For a row, its release or the release of the first missed row before it. For a run, the time at which
  /// the run usually begins in its row.
  std::int64_t due_ns = 0;
  Nanoseconds late{};
  std::uint64_t missed = 0;  ///< number of missed rows before this row
  Cause cause = Cause::unknown;
  std::optional<std::uint32_t> culprit{};  ///< the module that took too long
  Nanoseconds took{};                      ///< the culprit's run time
  Nanoseconds usual{};                     ///< the culprit's usual run time
  Evidence evidence{};
};

/// The usual values of an executor, and the limit above which a start counts as late.
struct Usual {
  /// Ten times the median lateness, but at most half a basic period, and never less than 20 us.
  Nanoseconds threshold{};
  Nanoseconds row{};  ///< the median duration of a row
};
Usual usual_of(const Timeline& line, Nanoseconds basic_period);

/// Returns the evidence about a thread between two instants. `thread` is 0 for rows, 1 for sporadic modules.
Evidence evidence_between(const std::vector<Sample>& samples, std::size_t executor, std::size_t thread,
                          std::int64_t from_ns, std::int64_t to_ns);

/// Finds every late start in the rows of an executor, in order. If the greatest of the counted times explains
/// half of the delay, it is the cause. Otherwise the cause of a late row is the previous row, if that had not
/// ended, else the wake-up. The cause of a late run is a module before it.
std::vector<LateStart> late_starts(const Recording& recording, std::size_t executor, const Timeline& line);

/// Formats a duration with three digits, such as "3.21 ms".
std::string in_short(Nanoseconds duration);
/// Describes a late start, such as "servo ran 3.21 ms in the previous row (usually 41 us); 812 page faults".
std::string in_words(const LateStart& late, const std::vector<Module>& modules);

}  // namespace takt::flight
