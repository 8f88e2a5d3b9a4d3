// Why something began late: a pure function of what was recorded.
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
  own_overrun,  ///< the executor's row before it took too long
  predecessor,  ///< a module before it in its row took too long
  wake_up,      ///< the thread was woken late, and nothing else is to be seen
  preemption,   ///< another thread had its processor, or its process was stopped
  page_fault,   ///< the kernel gave it memory
  hypervisor,   ///< another virtual machine had its processor (steal)
  unknown,      ///< nobody looked then
};
inline constexpr std::array<Cause, 7> kCauses{Cause::own_overrun, Cause::predecessor, Cause::wake_up,
                                              Cause::preemption,  Cause::page_fault,  Cause::hypervisor,
                                              Cause::unknown};
/// "own overrun", "predecessor", "wake-up", ...
const char* to_text(Cause cause) noexcept;

/// What the kernel counted in a window, beyond what is usual; as long as the samples around it are apart.
struct Evidence {
  bool looked = false;   ///< there are samples before and after
  Nanoseconds waited{};  ///< for a processor
  std::uint64_t gave_way = 0;
  std::uint64_t minor_faults = 0;
  std::uint64_t major_faults = 0;
  Nanoseconds stolen{};  ///< from the processor that it was on
  bool stopped = false;
};

struct LateStart {
  std::optional<std::size_t> run;  ///< of the timeline's; none: the row itself
  std::size_t row = 0;
  std::int64_t due_ns = 0;  ///< of a row its release, or that of the first row that was missed before it; of
                            ///< a run when it usually begins in its row
  Nanoseconds late{};
  std::uint64_t missed = 0;  ///< rows before it
  Cause cause = Cause::unknown;
  std::optional<std::uint32_t> culprit{};  ///< the module that took too long
  Nanoseconds took{};                      ///< by the culprit
  Nanoseconds usual{};                     ///< what it takes as a rule
  Evidence evidence{};
};

/// When a start is called late, and what is usual.
struct Usual {
  Nanoseconds threshold{};  ///< 20 us, or ten times the lateness that half of the rows stay below, if that is
                            ///< more; at most half a basic period, if that is more than 20 us
  Nanoseconds row{};        ///< half of the rows take less
};
Usual usual_of(const Timeline& line, Nanoseconds basic_period);

/// What was counted for a thread between two instants. `thread`: 0 of rows, 1 of sporadic modules.
Evidence evidence_between(const std::vector<Sample>& samples, std::size_t executor, std::size_t thread,
                          std::int64_t from_ns, std::int64_t to_ns);

/// Every late start of the rows of an executor, in their order. What the kernel counted is a cause where it
/// accounts for half of the delay, the greatest of them; otherwise the row before, then the wake-up.
std::vector<LateStart> late_starts(const Recording& recording, std::size_t executor, const Timeline& line);

/// Three digits: "3.21 ms".
std::string in_short(Nanoseconds duration);
/// "servo ran 3.21 ms in the row before (usually 41 us); 812 page faults"
std::string in_words(const LateStart& late, const std::vector<Module>& modules);

}  // namespace takt::flight
