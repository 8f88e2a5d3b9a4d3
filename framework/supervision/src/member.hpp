// A module under supervision: its lifecycle state, the process of a process module, and pending requests.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include <takt/channel/activity.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/removal.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/lifecycle/recovery.hpp>
#include <takt/model/cell.hpp>
#include <takt/supervision/platform.hpp>
#include <takt/supervision/supervised.hpp>
#include <takt/supervision/wiring.hpp>

namespace takt::supervision {

/// An operator's command to a module, until it is answered.
struct PendingCommand {
  Verb verb = Verb::stop;
  std::function<void(const Outcome&)> done;
  Instant since{};
  bool begun = false;
  int attempts = 0;  ///< number of recovery attempts when the command began
};

/// A swap in progress: a new instance is to replace the running one.
struct PendingSwap {
  std::string path;
  std::function<void(const Outcome&)> done;
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
  /// Whether the module's program is running.
  [[nodiscard]] bool runs() const { return program != nullptr && program->running(); }
  [[nodiscard]] bool in_tables() const noexcept {
    return block.in_tables.load(std::memory_order_seq_cst) != 0;
  }
  /// How often the module was called or released.
  [[nodiscard]] std::uint64_t releases() const noexcept {
    constexpr auto relaxed = std::memory_order_relaxed;
    return block.cycles.load(relaxed) + (slot == nullptr ? 0 : slot->begun.load(relaxed));
  }
  [[nodiscard]] std::uint64_t overruns() const noexcept {
    constexpr auto relaxed = std::memory_order_relaxed;
    return block.overruns.load(relaxed) + (slot == nullptr ? 0 : slot->late.load(relaxed));
  }

  const model::Module& model;
  std::uint32_t index;
  channel::ModuleBlock& block;
  lifecycle::Machine machine;
  lifecycle::Recovery recovery;
  std::size_t host = 0;      ///< index of the host that loads the module, or whose executor releases it
  bool reload = false;       ///< its instance was lost with its host, so a recovery must load it again
  channel::Removal removal;  ///< its last removal from the tables

  /// The state that the node aims for: EXECUTING, unless an operator has commanded another state.
  lifecycle::State up_to = lifecycle::State::executing;
  [[nodiscard]] bool wanted() const noexcept { return up_to == lifecycle::State::executing; }
  std::optional<PendingCommand> command;  ///< an operator's command in progress
  std::optional<PendingSwap> swap;
  bool lost = false;         ///< none of its hooks can be called again: it crashed the host, or a hook hangs
  bool failed = false;       ///< given up after an error
  std::string why;           ///< the text of its last failure
  std::uint64_t errors = 0;  ///< errors that only the node saw, not the executor
  std::uint64_t recoveries = 0;           ///< successful recoveries
  std::uint64_t seen_cycles = 0;          ///< its cycles_of() when it was last put into the tables
  std::optional<channel::Doing> pending;  ///< a hook that the host was asked to call

  // The following members are used for process modules.
  channel::ReleaseSlot* slot = nullptr;  ///< null if the module has no releases
  std::unique_ptr<Program> program;      ///< null for a thread module
  Instant spawned{};
  Instant told_to_end{};
  bool killed_for_hanging = false;
  std::vector<Wiring::Wire*> inputs;  ///< inputs with a deadline; also used for thread modules
  Instant put_in_at{};                ///< when it was put into the tables
  /// Whether the node put the module into the tables. If the module is no longer in them, an executor took it
  /// out because of an error that step() has not seen yet.
  bool put_in = false;
  bool stale = false;  ///< it is in RECOVER because an input was stale

  bool started_again = false;   ///< a recovery attempt restarted the program, which is not ready yet
  std::uint64_t seen_late = 0;  ///< value of slot->late at the last check
  int end_signals = 0;  ///< how the program was told to end: 0 by its slot, 1 by SIGTERM, 2 by SIGKILL
};

}  // namespace takt::supervision
