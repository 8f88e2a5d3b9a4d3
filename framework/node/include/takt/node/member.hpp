// A module under supervision: its place in the lifecycle, its program if it is one, and what is being waited
// for.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>

#include <takt/channel/activity.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/removal.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/lifecycle/recovery.hpp>
#include <takt/model/cell.hpp>
#include <takt/node/output.hpp>
#include <takt/node/supervised.hpp>
#include <takt/node/wiring.hpp>
#include <takt/os/process.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::node {

/// What an operator asked of a module, until it is answered.
struct Order {
  Verb verb = Verb::stop;
  std::function<void(const Outcome&)> done;
  Instant since{};
  bool begun = false;
  int attempts = 0;  ///< to recover, before this one
};

/// Another instance is to take the place of the one that runs.
struct SwapOrder {
  std::string path;
  std::function<void(const Outcome&)> done;
};

/// How far the health of a port is in the fault record.
struct NotedPort {
  std::uint32_t matched = 0;
  bool lost = false;  ///< somebody who matched is not there
  bool stale = false;
  std::uint64_t late = 0;
  std::uint64_t refused = 0;
};

struct Member {
  Member(const model::Module& m, std::uint32_t i, channel::ModuleBlock& b)
      : model(m),
        index(i),
        block(b),
        recovery({.attempts = m.recovery.attempts, .backoff = m.recovery.backoff}) {}

  [[nodiscard]] bool is_thread() const noexcept { return model.type == model::ModuleType::thread; }
  [[nodiscard]] bool is_process() const noexcept { return !is_thread(); }
  [[nodiscard]] bool scheduled() const noexcept { return model.operation != model::Operation::non_real; }
  [[nodiscard]] lifecycle::State state() const noexcept { return machine.state(); }
  [[nodiscard]] bool in_tables() const noexcept {
    return block.in_tables.load(std::memory_order_seq_cst) != 0;
  }

  const model::Module& model;
  std::uint32_t index;
  channel::ModuleBlock& block;
  lifecycle::Machine machine;
  lifecycle::Recovery recovery;
  std::size_t host = 0;      ///< of Supervisor::hosts_: that loads it, or whose executor releases it
  bool reload = false;       ///< its instance is gone with its host: to recover it is to load it afresh
  channel::Removal removal;  ///< of the last time that it was taken out of the tables

  /// How far the node brings it by itself: to EXECUTING, unless an operator said otherwise.
  lifecycle::State up_to = lifecycle::State::executing;
  [[nodiscard]] bool wanted() const noexcept { return up_to == lifecycle::State::executing; }
  std::optional<Order> order;  ///< of an operator, under way
  std::optional<SwapOrder> swap;
  bool lost =
      false;  ///< no hook of it can be called any more: it crashed the host, or a hook never came back
  bool failed = false;                    ///< given up after an error
  std::string why;                        ///< its last failure, in words
  std::uint64_t errors = 0;               ///< that the executor did not see
  std::uint64_t recoveries = 0;           ///< that succeeded
  std::uint64_t seen_cycles = 0;          ///< its cycles_of() when it was last put into the tables
  std::optional<channel::Doing> pending;  ///< a hook that the host was asked to call

  // A process module's.
  os::SharedMemory seat_memory;
  channel::ReleaseSlot* slot = nullptr;
  os::Child child;
  Output output;
  Instant spawned{};
  Instant told_to_end{};
  int last_pid = 0;
  bool killed_for_hanging = false;
  std::vector<Wiring::Wire*> inputs;  ///< that have a deadline; of any module
  Instant put_in_at{};                ///< into the tables
  bool stale = false;                 ///< it is in RECOVER because an input was stale

  bool started_again = false;        ///< by an attempt to recover; it is to become ready
  std::uint64_t seen_late = 0;       ///< of slot->late
  std::uint64_t noted_overruns = 0;  ///< how far they are in the fault record
  std::map<std::string, NotedPort> noted_ports;
  int end_signals = 0;  ///< how far its end has been pressed: 0 asked, 1 SIGTERM, 2 SIGKILL
};

}  // namespace takt::node
