// Everything that happens in a simulated cell, one after the other: what the trace is written from, and what
// the invariants are checked on.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <takt/component.hpp>
#include <takt/core/time.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/lifecycle/table.hpp>
#include <takt/model/cell.hpp>

namespace takt::simulation {

enum class What : std::uint8_t {
  // Of an executor
  woke,    ///< for the row that is due next: `number`, `release`
  walked,  ///< the row `number` of `release`; `count` rows before it were missed
  joined,  ///< its grid: the next row is `number`; `count` rows before it were missed
  // Of a module
  put_in,     ///< the tables
  taken_out,  ///< of the tables
  ready,      ///< a sporadic one: its condition held; run by `until`
  run,        ///< run() begins: `number`, `release`
  ran,        ///< run() ended after `took`; `error` is what the executor will make of it
  released,   ///< a program: `number`, `release`
  busy,       ///< a program was still in its body when its row came
  body,       ///< a program begins the body of `number`, `release`
  done,       ///< a program has come back to its wait after `took`
  step,       ///< through its lifecycle
  recovery,   ///< is tried: attempt `number` of `count`
  // Of a connection
  wrote,    ///< sample `number`
  read,     ///< sample `number`; `count` is not 0 when its bytes were not what was written
  arrived,  ///< sample `number` at the reader's device
  lost,     ///< sample `number` on the way
  // Of a device
  host_ended,  ///< its host crashed or was ended; nothing it was doing goes on
  host_began,
  halted,  ///< all executors
  fault,   ///< the next thing that goes wrong is on purpose
};

struct Event {
  static constexpr std::uint32_t kNone = ~0U;

  Instant at{};
  What what = What::fault;
  std::uint32_t device = kNone;
  std::uint32_t executor = kNone;
  std::uint32_t module = kNone;
  std::uint32_t connection = kNone;  ///< its index in the cell
  std::uint64_t number = 0;
  std::uint64_t count = 0;
  Instant release{};
  Instant until{};
  Nanoseconds took{};
  ErrorType error = ErrorType::none;
  lifecycle::Transition step{};
  std::string_view text{};  ///< valid during the call
};

class Listener {
 public:
  virtual ~Listener() = default;
  virtual void hear(const Event& event) = 0;
};

/// "+0.001000412 robot.servo ran 10.6 us": the time since T0 in seconds, who, what. Without a line feed.
std::string to_text(const Event& event, const model::Cell& cell, Instant t0);

}  // namespace takt::simulation
