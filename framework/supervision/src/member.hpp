// A module under supervision: its lifecycle state, the process of a process module, and pending requests.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include <takt/channel/activity.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/removal.hpp>
#include <takt/host/log_reader.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/lifecycle/recovery.hpp>
#include <takt/model/cell.hpp>
#include <takt/supervision/platform.hpp>
#include <takt/supervision/supervised.hpp>
#include <takt/supervision/wiring.hpp>
#include "log_limit.hpp"
#include "watch.hpp"

namespace takt::supervision {

/// An operator's command to a module, until it is answered.
struct PendingCommand {
  Verb verb = Verb::stop;
  std::function<void(const Outcome&)> done;
  Instant since{};
  bool begun = false;
  int attempts = 0;  ///< number of recovery attempts when the command began
};

/// A swap in progress, in which a new instance replaces the running one.
struct PendingSwap {
  std::string path;
  std::map<std::string, std::string> values;  // properties that only the new instance has
  std::function<void(const Outcome&)> done;
};

/// The reason that is reported when a module that has finished goes to DESTRUCT.
inline constexpr const char* kFinished = "it has finished";
/// The status text of a module that has reported a safe stop.
inline constexpr const char* kSafeStop = "it is in a safe stop";

struct Member {
  Member(const model::Module& m, std::uint32_t i, channel::ModuleBlock& b)
      : model(m),
        index(i),
        block(b),
        recovery({.attempts = m.recovery.attempts, .backoff = m.recovery.backoff}) {}

  /// The module's log ring; null if it has none.
  [[nodiscard]] channel::LogRing* log_ring() const noexcept {
    if (is_thread()) return &block.log;
    return slot == nullptr ? nullptr : &slot->log;
  }
  /// True if the module is in EXECUTING and has reported that it is in a safe stop.
  [[nodiscard]] bool in_safe_stop() const noexcept {
    const channel::LogRing* const ring = log_ring();
    return state() == lifecycle::State::executing && ring != nullptr &&
           ring->safe_stop.load(std::memory_order_relaxed) != 0;
  }
  [[nodiscard]] bool is_thread() const noexcept { return model.type == model::ModuleType::thread; }
  [[nodiscard]] bool is_process() const noexcept { return !is_thread(); }
  [[nodiscard]] bool scheduled() const noexcept { return model.operation != model::Operation::non_real; }
  [[nodiscard]] lifecycle::State state() const noexcept { return machine.state(); }
  /// True if the process of this process module is running.
  [[nodiscard]] bool runs() const { return program != nullptr && program->running(); }
  [[nodiscard]] bool in_tables() const noexcept {
    return block.in_tables.load(std::memory_order_seq_cst) != 0;
  }
  /// True if a run() reported that it was the last one, or if the program ended with status 0.
  [[nodiscard]] bool has_finished() const noexcept {
    return block.finished.load(std::memory_order_acquire) != 0;
  }
  /// The number of times that the module was called or released.
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
  bool reload = false;       ///< true: the module's instance was lost with its host, so the recovery must
                             ///< load the module again
  channel::Removal removal;  ///< the module's last removal from the tables

  /// The state that the node aims for: EXECUTING, unless an operator has commanded another state.
  lifecycle::State up_to = lifecycle::State::executing;
  [[nodiscard]] bool wanted() const noexcept { return up_to == lifecycle::State::executing; }
  /// True if an operator stopped the module: it stays in START until an operator starts it.
  [[nodiscard]] bool stopped() const noexcept { return state() == lifecycle::State::start && !wanted(); }
  /// True if the module is in START and waits for its first release since a start.
  [[nodiscard]] bool awaits_release() const noexcept {
    return state() == lifecycle::State::start && wanted();
  }
  std::optional<PendingCommand> command;  ///< an operator's command in progress
  std::optional<PendingSwap> swap;
  bool lost = false;              ///< true: no hook of the module can be called any more, because the module
                                  ///< crashed its host or a hook hangs
  bool failed = false;            ///< true if the module was given up after an error
  std::string why;                ///< the text of the module's last failure
  std::set<std::string> set;      ///< the properties that an operator has set since the deployment
  std::uint64_t errors = 0;       ///< number of steps to RECOVER, plus the number of crashes and hangs in a
                                  ///< state from which no such step is possible
  std::uint64_t recoveries = 0;   ///< number of successful recoveries
  std::uint64_t seen_cycles = 0;  ///< value of cycles_of() when the module was last put into the
                                  ///< tables
  std::optional<channel::Doing> pending;  ///< the hook that the host was asked to call; empty after the
                                          ///< answer

  std::optional<host::LogReader> log;  ///< empty for a process module without releases
  std::optional<LogLimit> log_limit;   ///< empty if `log` is empty
  bool safe_stop_recorded = false;     ///< the result of in_safe_stop() that was recorded last

  // The following members are used for process modules.
  channel::ReleaseSlot* slot = nullptr;  ///< null if the module has no releases
  std::unique_ptr<Program> program;      ///< null for a thread module
  Instant spawned{};
  Instant told_to_end{};
  std::string hung;  ///< why the node killed the program: "did not return to waitPeriod() within 1.01 s";
                     ///< empty if the node did not kill it
  std::vector<Wiring::CreatedLink*> inputs;  ///< inputs with a deadline; also used for thread modules
  Watch cycles;                              ///< watches the number of the module's cycles
  Watch body;                                ///< watches the body of the program that is in progress
  Instant put_in_at{};                       ///< time at which the module was last put into the tables
  /// True from put_in_tables() to take_from_tables(). If this is true and in_tables() is false, the module
  /// has left the tables by itself: step() has not yet noticed its error or its last run.
  bool put_in = false;
  bool stale = false;  ///< true if the module is in RECOVER because an input was stale

  bool started_again = false;   ///< true if a recovery attempt restarted the program, and the program is not
                                ///< ready yet
  std::uint64_t seen_late = 0;  ///< value of slot->late at the last check
  int end_signals = 0;  ///< the means used so far to end the program: 0 for the flag in its slot, 1 for
                        ///< SIGTERM, 2 for SIGKILL
};

}  // namespace takt::supervision
