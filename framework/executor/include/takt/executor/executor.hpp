// The heart: each basic period, walk one row of the periodic table, then check the conditions of the sporadic
// modules.
//
// An executor owns no thread and no clock. It is told the time, so that a test or a simulation runs a million
// cycles in a second with the code that runs in the cell.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include <takt/channel/flight.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/component.hpp>
#include <takt/core/clock.hpp>
#include <takt/executor/body.hpp>
#include <takt/executor/exchange.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::executor {

/// A module in the tables: what to call or release, and where to keep count. What each release needs is in
/// the first cache line.
struct alignas(64) Unit {
  std::uint32_t index = 0;                       ///< of the module on its device
  Body* body = nullptr;                          ///< of a thread module
  channel::ReleaseSlot* slot = nullptr;  ///< of a process module
  channel::ModuleBlock* block = nullptr;         ///< never null
  Nanoseconds period{};                          ///< of a periodic module
  Nanoseconds deadline{};                        ///< of a sporadic module, from its release
  Nanoseconds budget{};                          ///< 0: none
  Nanoseconds interarrival{};          ///< of a sporadic module: the least time between two releases; 0: any
  bool immediate = false;              ///< a sporadic module that is released by its events, not by rows
  bool late_is_error = false;          ///< a sporadic module that misses its deadline is in error
  model::OverrunContract overrun{};    ///< of a periodic module
  model::BudgetTolerance tolerance{};  ///< of the budget
  Exchange* trial = nullptr;           ///< of its body; the executor's own
};

/// Where an executor's threads record what they do; null: nowhere. Each outlives it.
struct Flight {
  channel::FlightWriter* rows = nullptr;
  channel::FlightWriter* sporadic = nullptr;
};

class Executor {
 public:
  /// `periodic` and `sporadic` are in the order of the plan's lists; the plan is copied. Allocates; nothing
  /// after this does. `clock` and the blocks outlive the executor.
  Executor(const schedule::ExecutorPlan& plan, std::vector<Unit> periodic, std::vector<Unit> sporadic,
           channel::ExecutorBlock& block, Clock& clock, Flight flight = {});

  /// Puts the executor on its grid T0 + n x basic period, at the first release that is not before `now`. What
  /// lies between block.next_row and that (a restart of the host) is counted as missed. An executor without
  /// modules has no grid to join.
  void join_grid(Instant t0, Instant now) noexcept;

  /// When the next row is due. Never leaves the grid.
  [[nodiscard]] Instant next_release() const noexcept { return release_; }
  [[nodiscard]] Nanoseconds basic_period() const noexcept { return basic_; }
  /// The row that is due next, counted from T0.
  [[nodiscard]] std::uint64_t next_row() const noexcept { return row_; }

  /// Real-time. Walks the row that is due at `now` (not before next_release()): if whole slots have passed,
  /// their rows are missed, and the row of the slot that `now` lies in runs, late; what the modules of a
  /// missed row get is as their overrun contracts say, before that row. Then the conditions. Returns the bits
  /// of the wake_word that must be rung: for programs that sleep, and for the sporadic thread.
  std::uint32_t run_cycle(Instant now) noexcept;

  /// Real-time, on the thread of the sporadic modules (which may be another than run_cycle's). Releases the
  /// modules that are dispatched at once and have news; then runs the ready module with the earliest absolute
  /// deadline, ties by the order of the table. False when none is ready.
  bool run_sporadic() noexcept;

  /// Has a module's body exchanged before the next row that finds it in the tables. From another thread, one
  /// at a time: until it is kept or put back, or was withdrawn.
  void exchange(Exchange& exchange) noexcept;
  /// False: a row has taken it up.
  bool withdraw() noexcept;

 private:
  enum class Ready : std::uint32_t { no, yes };
  struct Sporadic {
    Unit unit;
    std::atomic<Ready> ready{Ready::no};  // SYNC: ready, publishes the two below
    std::int64_t release_ns = 0;
    std::int64_t deadline_ns = 0;
    std::uint64_t cycle = 0;
    /// No release before. Written by the thread that releases it: rows', or, of an immediate one, the
    /// sporadic thread.
    std::atomic<std::int64_t> not_before_ns{0};
  };

  /// Whether there is another instance from this row on.
  bool begin_exchange() noexcept;
  void watch_trial() noexcept;
  void end_trial(Exchange::State state) noexcept;
  void put_back(ErrorType type, std::uint64_t cycle, const char* text) noexcept;
  /// The rows from row_ on, as many, are not walked in their slots: they are counted, and row_ is behind
  /// them. As with skip whatever the contracts say.
  void skip(std::uint64_t rows) noexcept;
  void pass(std::uint64_t rows) noexcept;
  /// The same by the contracts. Returns the bits of the wake_word that must be rung.
  std::uint32_t overrun(std::uint64_t rows) noexcept;
  /// Makes up what the contracts allow of as many rows before row_, in their order.
  std::uint32_t catch_up(std::uint64_t rows) noexcept;
  [[nodiscard]] std::uint64_t number_at(std::size_t unit, std::uint64_t row) const noexcept {
    const std::uint64_t since = row - first_rows_[unit];
    return strides_[unit] == 1 ? since : since / strides_[unit];  // a division takes longer than the rest
  }
  /// A periodic module's release: a thread module is called, a program released.
  Instant serve(std::size_t unit, std::uint64_t number, Instant release, Instant now,
                std::uint32_t* wake) noexcept;
  /// `now`: after the row's last module.
  std::uint32_t check_conditions(Instant release, Instant now) noexcept;
  void release_immediate() noexcept;
  void make_ready(Sporadic& sporadic, Instant release, std::uint64_t cycle) noexcept;
  /// Calls a thread module that was released at `release`; returns the time after it.
  Instant call(const Unit& unit, channel::Activity& activity, channel::FlightWriter& flight,
               std::uint64_t number, Instant release, Nanoseconds allowed, Instant start) noexcept;
  /// Records the body that a program has ended since this was called last.
  void record_body(const Unit& unit, std::uint32_t& seen) noexcept;
  void check_budget(const Unit& unit, std::uint64_t number, Nanoseconds took) noexcept;
  void raise_missed(const Unit& unit, std::uint64_t cycle, std::uint64_t releases) noexcept;
  void raise_late(const Unit& unit, std::uint64_t cycle, Nanoseconds by) noexcept;
  void raise(const Unit& unit, ErrorType type, std::uint64_t cycle, const char* text) noexcept;

  schedule::Table table_;
  std::vector<Unit> periodic_;
  std::vector<std::uint64_t> strides_;     // rows between two releases of a periodic unit
  std::vector<std::uint64_t> first_rows_;  // of a periodic unit
  std::uint64_t longest_catch_up_ = 0;     // rows that any contract may make up; 0: none does
  bool only_skip_ = true;                  // no contract but skip
  std::vector<std::uint64_t> made_up_;     // of a catch-up unit: its first release that is made up
  std::unique_ptr<Sporadic[]> sporadic_;
  std::size_t sporadic_count_ = 0;
  bool has_immediate_ = false;
  std::vector<std::uint32_t>
      bodies_seen_;  // of programs, periodic and then sporadic: the last that was recorded
  channel::FlightWriter nowhere_;
  channel::FlightWriter& rows_;
  channel::FlightWriter& runs_;  // of sporadic modules
  channel::ExecutorBlock& block_;
  Clock& clock_;
  Nanoseconds basic_;
  std::uint64_t rows_in_table_;
  std::uint64_t row_ = 0;
  std::uint64_t table_row_ = 0;  // row_ modulo rows_in_table_
  Instant release_{};
  std::atomic<Exchange*> asked_{nullptr};  // SYNC: exchange
  std::size_t tried_ = 0;                  // the unit whose body is on trial
  Body* before_ = nullptr;                 // and the one before that; null: none is
  std::uint64_t trial_ends_ = 0;           // at this number of its cycles
};

}  // namespace takt::executor
