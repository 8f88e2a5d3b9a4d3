// What goes wrong in a simulated cell: as an integrator writes it down, or drawn from the seed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/simulation/draws.hpp>

namespace takt::simulation {

struct Fault {
  enum class Kind : std::uint8_t {
    late,        ///< the module's next run takes `by` longer
    crash,       ///< the module's next run ends its process
    fail,        ///< the module's next run fails
    hang,        ///< the module's next run never comes back
    unmended,    ///< the module's next `count` attempts to recover fail
    oversleep,   ///< the executor's next wake-up comes `by` late
    clock_step,  ///< the device's wall clock is set forward by `by`, which may be negative
    cut,         ///< nothing gets from one device to the other, either way, for `by`
    lose,        ///< the connection's next `count` samples are lost on the way
    delay,       ///< the connection's next sample is on its way for `by` longer
  };
  Kind kind = Kind::late;
  Nanoseconds at{};  ///< since T0; not negative
  std::uint32_t device = 0;
  std::uint32_t place = 0;  ///< module, executor, connection or other device, by its index
  Nanoseconds by{};
  std::uint64_t count = 0;

  bool operator==(const Fault&) const = default;
};

/// One line of a script: "at 1.5 s robot.servo late 3 ms".
std::string to_text(const Fault& fault, const model::Cell& cell);

/// One fault a line, `#` begins a comment; README.md of this folder has the words. Every mistake of the
/// script at once, each with `file:line`.
Result<std::vector<Fault>> parse_script(std::string_view text, const std::string& file,
                                        const model::Cell& cell);

/// The words of a script, for a help text.
std::string script_help();

/// `per_second` of them on average, of every kind that the cell has a place for.
std::vector<Fault> draw_faults(const model::Cell& cell, Draws& draws, Nanoseconds length, double per_second);

}  // namespace takt::simulation
