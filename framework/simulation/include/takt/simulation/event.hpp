// The events of a simulated cell, in order. The trace is written from them, and the invariants check them.
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
  // Events of an executor
  woke,    ///< it woke for the row that is due next: `number`, `release`
  walked,  ///< it ran row `number`, which was due at `release`; it had missed `count` rows before
  joined,  ///< it joined its grid: the next row is `number`; it had missed `count` rows before
  // Events of a module
  put_in,     ///< it was put into the tables
  taken_out,  ///< it was taken out of the tables
  ready,      ///< the condition of a sporadic module was true; the module must run by `until`
  run,        ///< run() begins: `number`, `release`
  ran,        ///< run() ended after `took`; `error` is the error that the executor will raise
  released,   ///< a program was released: `number`, `release`
  busy,       ///< a program was still in its body when its row came
  body,       ///< a program begins the body of `number`, `release`
  done,       ///< a program returned to its wait after `took`
  step,       ///< a lifecycle transition
  recovery,   ///< recovery attempt `number` of `count`
  answered,   ///< an operator's command was carried out or rejected; the text says which
  // Events of a connection
  wrote,    ///< sample `number` was written
  read,     ///< sample `number` was read; `count` is not 0 if its bytes differ from what was written
  arrived,  ///< sample `number` arrived at the reader's device
  lost,     ///< sample `number` was lost on the way
  safe,     ///< its reader gets the safe value from now on if `count` is 1, and samples again if it is 0
  // Events of a host
  host_ended,  ///< it crashed or was ended, and everything in it stopped
  host_began,
  halted,  ///< all its executors halted
  // Events of a device
  fault,  ///< a fault was injected
};

struct Event {
  static constexpr std::uint32_t kNone = ~0U;

  Instant at{};
  What what = What::fault;
  std::uint32_t device = kNone;
  std::uint32_t executor = kNone;
  std::uint32_t module = kNone;
  std::uint32_t connection = kNone;  ///< its index in the cell
  std::uint32_t host = kNone;        ///< its index in model::hosts_of(device)
  std::uint64_t number = 0;
  std::uint64_t count = 0;
  Instant release{};
  Instant until{};
  Nanoseconds took{};
  ErrorType error = ErrorType::none;
  lifecycle::Transition step{};
  std::string_view text{};  ///< valid only during on_event()
};

class Listener {
 public:
  virtual ~Listener() = default;
  virtual void on_event(const Event& event) = 0;
};

/// "+0.001000412 robot.servo ran 10.6 us": the time since T0 in seconds, the subject and the event. Without a
/// line feed.
std::string to_text(const Event& event, const model::Cell& cell, Instant t0);

}  // namespace takt::simulation
