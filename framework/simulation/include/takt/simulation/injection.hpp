// Faults that are injected into a simulated cell, and what the operator does to it. Both come from a script;
// faults can also be drawn from the seed.
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

/// A fault that is injected into a simulated cell, or an action of the operator.
struct Injection {
  enum class Kind : std::uint8_t {
    late,        ///< the module's next run takes `by` longer
    crash,       ///< the module's next run, or call of `hook`, crashes its process
    fail,        ///< the module's next run, or call of `hook`, fails
    hang,        ///< the module's next run, or call of `hook`, never returns
    unmended,    ///< the module's next `count` recovery attempts fail
    oversleep,   ///< the executor's next wake-up is `by` late
    clock_step,  ///< the device's wall clock is set forward by `by`, which may be negative
    cut,         ///< nothing passes between `device` and `target`, in either direction, for `by`
    lose,        ///< the connection's next `count` samples are lost on the way
    delay,       ///< the connection's next sample takes `by` longer
    finish,      ///< the module's next run is its last one, because the module has finished
    down,        ///< the device loses its power; its node starts again after `by`
    pause,       ///< the node of the device gets no CPU for `by`
    twin,        ///< a second node with the device's name starts
    deploy,      ///< the operator deploys the cell
    update,      ///< the operator updates the cell to another descriptor
    undeploy,
    // An operator's command to the module
    initialize,
    start,
    stop,
    recover,
    reset,
    destruct,
    swap,  ///< an update replaces the module's instance while it runs
  };
  enum class Target : std::uint8_t { module, executor, device, link, connection, cell };

  Kind kind = Kind::late;
  Nanoseconds at{};          ///< time since T0; not negative
  std::uint32_t device = 0;  ///< the number of devices for the operator
  std::uint32_t target = 0;  ///< index of the module, executor, connection or other device
  Nanoseconds by{};
  std::uint64_t count = 0;
  /// The call in which a crash, failure or hang happens: a hook or run(). A process module has no hooks.
  channel::Doing hook = channel::Doing::run;

  bool operator==(const Injection&) const = default;
};

[[nodiscard]] Injection::Target target_of(Injection::Kind kind);

/// Returns the injection as a line of a script, such as "at 1.5 s robot.servo late 3 ms".
std::string to_text(const Injection& injection, const model::Cell& cell);

/// Parses one fault or command per line; `#` begins a comment. The room's README.md lists the words. On
/// failure, returns every mistake in the script, each with `file:line`.
Result<std::vector<Injection>> parse_script(std::string_view text, const std::string& file,
                                            const model::Cell& cell);

/// Returns the help text about scripts: an example and an explanation for each fault.
std::string script_help();

/// Draws `per_second` faults per second on average, of all kinds up to `delay` that are possible in the cell.
std::vector<Injection> draw_injections(const model::Cell& cell, Draws& draws, Nanoseconds length,
                                       double per_second);

}  // namespace takt::simulation
