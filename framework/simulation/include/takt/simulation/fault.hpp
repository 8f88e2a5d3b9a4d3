// What happens to a simulated cell: faults and commands from an integrator's script, or faults drawn from the
// seed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <takt/channel/activity.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/simulation/draws.hpp>

namespace takt::simulation {

struct Fault {
  enum class Kind : std::uint8_t {
    late,        ///< the module's next run takes `by` longer
    crash,       ///< the module's next run, or call of `hook`, ends its process
    fail,        ///< the module's next run, or call of `hook`, fails
    hang,        ///< the module's next run, or call of `hook`, never returns
    unmended,    ///< the module's next `count` recovery attempts fail
    oversleep,   ///< the executor's next wake-up is `by` late
    clock_step,  ///< the device's wall clock is set forward by `by`, which may be negative
    cut,         ///< nothing passes between the two devices, in either direction, for `by`
    lose,        ///< the connection's next `count` samples are lost on the way
    delay,       ///< the connection's next sample takes `by` longer
    // An operator's command to the module
    initialize,
    start,
    stop,
    recover,
    reset,
    destruct,
    swap,  ///< an update replaces the module's instance while it runs
  };
  Kind kind = Kind::late;
  Nanoseconds at{};  ///< time since T0; not negative
  std::uint32_t device = 0;
  std::uint32_t place = 0;  ///< index of the module, executor, connection or other device
  Nanoseconds by{};
  std::uint64_t count = 0;
  /// For a crash, a failure or a hang: the call in which it happens, a hook or run(). A program has no hooks.
  channel::Doing hook = channel::Doing::run;

  bool operator==(const Fault&) const = default;
};

/// One line of a script: "at 1.5 s robot.servo late 3 ms".
std::string to_text(const Fault& fault, const model::Cell& cell);

/// Parses one fault per line; `#` begins a comment. README.md of this folder lists the words. An error lists
/// every mistake of the script, each with `file:line`.
Result<std::vector<Fault>> parse_script(std::string_view text, const std::string& file,
                                        const model::Cell& cell);

/// The help text about scripts: an example and an explanation for each fault.
std::string script_help();

/// Draws `per_second` faults on average, of every kind that is possible in the cell. Draws no commands.
std::vector<Fault> draw_faults(const model::Cell& cell, Draws& draws, Nanoseconds length, double per_second);

}  // namespace takt::simulation
