// Finds the causes of rows and runs that began late. The result depends only on the recording.
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
  predecessor,  ///< a module that runs earlier in the row took too long
  wake_up,      ///< the thread was woken late, and no other cause is known
  preemption,   ///< another thread used the CPU, or the process was stopped
  page_fault,   ///< the kernel mapped memory for the thread
  hypervisor,   ///< another virtual machine used the CPU (steal time)
  unknown,      ///< the kernel's counters were not read before or after the delay
};
inline constexpr std::array<Cause, 7> kCauses{Cause::own_overrun, Cause::predecessor, Cause::wake_up,
                                              Cause::preemption,  Cause::page_fault,  Cause::hypervisor,
                                              Cause::unknown};
/// Returns the name of a cause, such as "own overrun" or "wake-up".
const char* to_text(Cause cause) noexcept;

/// The kernel's counts for a thread during a delay, from the last sample before the delay to the first sample
/// after it. `waited` excludes the usual waiting time.
struct Evidence {
  bool looked = false;         ///< true if there are samples before and after the delay
  Nanoseconds waited{};        ///< time that the thread waited for a CPU, beyond the usual time
  std::uint64_t gave_way = 0;  ///< number of preemptions
  std::uint64_t minor_faults = 0;
  std::uint64_t major_faults = 0;
  Nanoseconds stolen{};  ///< time that the hypervisor took from the thread's CPU
  bool stopped = false;
};

struct LateStart {
  /// Index of the late run in Timeline::runs; empty if the row itself began late.
  std::optional<std::size_t> run;
  std::size_t row = 0;
  /// For a late row, its release, or the release of the first missed row before it. For a late run, the time
  /// at which this run usually begins in its row.
  std::int64_t due_ns = 0;
  Nanoseconds late{};
  std::uint64_t missed = 0;  ///< number of rows that were missed just before this row
  Cause cause = Cause::unknown;
  std::optional<std::uint32_t> culprit{};  ///< the module that took too long
  Nanoseconds took{};                      ///< the culprit's run time
  Nanoseconds usual{};                     ///< the culprit's usual run time
  Evidence evidence{};
};

/// The usual values of an executor, and the limit above which a start counts as late.
struct Usual {
  /// A start counts as late if its lateness exceeds this limit. The limit is ten times the median lateness,
  /// but not above half a basic period and not below 20 us.
  Nanoseconds threshold{};
  Nanoseconds row{};  ///< the median duration of a row
};
Usual usual_of(const Timeline& line, Nanoseconds basic_period);

/// Returns the evidence about a thread of an executor between two instants. `thread` is 0 for the thread of
/// the rows, and 1 for the sporadic thread.
Evidence evidence_between(const std::vector<Sample>& samples, std::size_t executor, std::size_t thread,
                          std::int64_t from_ns, std::int64_t to_ns);

/// Returns every late start in the rows of an executor, in order, with its cause. First the kernel's counters
/// are compared: the cause with the greatest counted time is the cause of the delay, if this time is at least
/// half of the delay. If the counters do not explain the delay, the cause of a late row is the previous row
/// if that row had not ended when the late row was due, and otherwise the late wake-up of the thread. The
/// cause of a late run is, in this case, a module that ran before it in the same row.
std::vector<LateStart> late_starts(const Recording& recording, std::size_t executor, const Timeline& line);

/// Formats a duration with three digits, such as "3.21 ms".
std::string in_short(Nanoseconds duration);
/// Describes a late start, such as "servo ran 3.21 ms in the previous row (usually 41 us); 812 page faults".
std::string in_words(const LateStart& late, const std::vector<Module>& modules);

}  // namespace takt::flight
