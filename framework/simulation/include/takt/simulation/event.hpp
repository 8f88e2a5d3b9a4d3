// The events of a simulated cell, in order. The trace consists of these events, and the invariants check
// them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <takt/wire/takt.h>
#include <takt/component.hpp>
#include <takt/core/time.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/lifecycle/table.hpp>
#include <takt/model/cell.hpp>

namespace takt::simulation {

enum class What : std::uint8_t {
  // Events of an executor
  woke,    ///< the executor woke for row `number`, which is due at `release`
  walked,  ///< the executor ran row `number`, which was due at `release`, after `count` missed rows
  joined,  ///< the executor joined its grid: its next row is `number`, after `count` missed rows
  // Events of a module
  put_in,     ///< the module was put into the tables
  taken_out,  ///< the module was taken out of the tables
  ready,      ///< the condition of a sporadic module was true; the module must run by `until`
  run,        ///< run() begins, in cycle `number`, for the release at `release`
  ran,        ///< run() ended after `took`; `error` is the error that the executor will raise next
  released,   ///< a process module got release `number`, which is due at `release`
  busy,       ///< `count` releases came while a process module was in its body
  body,       ///< a process module began its body for release `number`, which was due at `release`
  done,       ///< a process module returned to its wait function after `took`
  step,       ///< a lifecycle transition
  recovery,   ///< recovery attempt `number` of `count`
  answered,   ///< an operator's command was carried out or rejected, as `text` states
  // Events of a connection
  wrote,    ///< sample `number` was written
  read,     ///< sample `number` was read; `count` is not 0 if its bytes differ from the written ones
  arrived,  ///< sample `number` arrived at the reader's device
  lost,     ///< sample `number` was lost on the way
  safe,     ///< from now on the reader gets the safe value (`count` is 1) or samples (`count` is 0)
  // Events of a host
  host_ended,  ///< the host crashed or was ended, and all its threads stopped
  host_began,
  halted,  ///< all executors of the host halted
  // Events of a device
  prepares,  ///< the device begins to prepare its modules, which are as new
  begins,    ///< the modules of the device begin; `release` is T0 of their rows
  fault,     ///< a fault was injected
  // Events of the operator
  operated,  ///< the operator has ended an action, as `text` states
};

struct Event {
  static constexpr std::uint32_t kNone = ~0U;

  Instant at{};
  What what = What::fault;
  std::uint32_t version = 0;  ///< the descriptor that the indices refer to: 0, or 1 for Options::update
  std::uint32_t device = kNone;
  std::uint32_t executor = kNone;
  std::uint32_t module = kNone;
  std::uint32_t connection = kNone;  ///< index of the connection in the cell
  std::uint32_t host = kNone;        ///< index of the host in model::hosts_of(device)
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
  /// Called for each status that the node of a device publishes.
  virtual void on_status(std::uint32_t device, const DeviceStatus& status) {
    static_cast<void>(device);
    static_cast<void>(status);
  }
};

/// Returns a line such as "+0.001000412 robot.servo ran 10600 ns": the time since T0 in seconds, the subject
/// and the event. The line has no line feed.
std::string to_text(const Event& event, const model::Cell& cell, Instant t0);

}  // namespace takt::simulation
