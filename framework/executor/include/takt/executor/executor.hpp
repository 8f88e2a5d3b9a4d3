// The scheduler: in each basic period it walks one row of the periodic table, then checks the conditions of
// the sporadic modules.
//
// An executor owns no thread and no clock. Its caller passes the time, so a test or a simulation runs a
// million cycles per second with the same code as the cell.
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

/// A module in the tables: what to call or release, and where to count. The members that each release needs
/// are in the first cache line.
struct alignas(64) Unit {
  std::uint32_t index = 0;                ///< the module's index on its device
  Body* body = nullptr;                   ///< of a thread module, else null
  channel::ReleaseSlot* slot = nullptr;   ///< of a process module, else null
  channel::ModuleBlock* block = nullptr;  ///< never null
  Nanoseconds period{};                   ///< of a periodic module
  Nanoseconds deadline{};                 ///< of a sporadic module, from its release
  Nanoseconds budget{};                   ///< 0: none
  Nanoseconds interarrival{};          ///< of a sporadic module: the least time between two releases; 0: any
  bool immediate = false;              ///< a sporadic module that is released by its events, not by rows
  bool late_is_error = false;          ///< a sporadic module that misses its deadline is in error
  model::OverrunContract overrun{};    ///< of a periodic module
  model::BudgetTolerance tolerance{};  ///< of the budget
  Exchange* trial = nullptr;           ///< the trial of its body; only the executor uses this
};

/// Where an executor's threads record what they do; null: nowhere. The writers must outlive the executor.
struct Flight {
  channel::FlightWriter* rows = nullptr;
  channel::FlightWriter* sporadic = nullptr;
};

class Executor {
 public:
  /// `periodic` and `sporadic` are in the order of the plan's lists; the plan is copied. Only the constructor
  /// allocates. `clock` and the blocks must outlive the executor.
  Executor(const schedule::ExecutorPlan& plan, std::vector<Unit> periodic, std::vector<Unit> sporadic,
           channel::ExecutorBlock& block, Clock& clock, Flight flight = {});

  /// Puts the executor on its grid T0 + n x basic period, at the first release that is not before `now`.
  /// After a restart of the host, the rows from block.next_row up to this release count as missed. Not for an
  /// executor without modules, which has no grid.
  void join_grid(Instant t0, Instant now) noexcept;

  /// When the next row is due; always a point of the grid.
  [[nodiscard]] Instant next_release() const noexcept { return release_; }
  [[nodiscard]] Nanoseconds basic_period() const noexcept { return basic_; }
  /// The row that is due next, counted from T0.
  [[nodiscard]] std::uint64_t next_row() const noexcept { return row_; }

  /// Walks the row that is due at `now` (not before next_release()), then checks the conditions. If whole
  /// slots have passed, their rows are missed, and the row of the slot that contains `now` runs, late. Before
  /// that row, the modules of missed rows are treated as their overrun contracts demand. Returns the bits of
  /// the wake word to ring: for sleeping programs and for the sporadic thread. Real-time safe.
  std::uint32_t run_cycle(Instant now) noexcept;

  /// Called on the thread of the sporadic modules, which may differ from run_cycle()'s. Releases the modules
  /// with immediate dispatch that have unread events. Then runs the ready module with the earliest absolute
  /// deadline; ties follow the order of the table. Returns false if none is ready. Real-time safe.
  bool run_sporadic() noexcept;

  /// Requests the exchange of a module's body before the next row that finds the module in the tables. Any
  /// other thread may call this. Only one exchange at a time is allowed: the next one may begin when this one
  /// is kept, put back or withdrawn.
  void exchange(Exchange& exchange) noexcept;
  /// Withdraws the exchange. Returns false if a row has already taken it.
  bool withdraw() noexcept;

 private:
  enum class Ready : std::uint32_t { no, yes };
  struct Sporadic {
    Unit unit;
    std::atomic<Ready> ready{Ready::no};  // SYNC: ready, publishes the three below
    std::int64_t release_ns = 0;
    std::int64_t deadline_ns = 0;
    std::uint64_t cycle = 0;
    /// No release before this time. Written by the thread that releases the module: the thread of the rows,
    /// or the sporadic thread for immediate dispatch.
    std::atomic<std::int64_t> not_before_ns{0};
  };

  /// Begins the requested exchange, if there is one. Returns whether a new body runs from this row on.
  bool begin_exchange() noexcept;
  void watch_trial() noexcept;
  void end_trial(Exchange::State state) noexcept;
  void put_back(ErrorType type, std::uint64_t cycle, const char* text) noexcept;
  /// Counts this many rows from row_ on as missed and moves row_ past them. Treats every module as if its
  /// contract were skip.
  void skip(std::uint64_t rows) noexcept;
  void pass(std::uint64_t rows) noexcept;
  /// Like skip(), but follows the modules' contracts. Returns the bits of the wake word to ring.
  std::uint32_t overrun(std::uint64_t rows) noexcept;
  /// Makes up for releases of this many rows before row_, in their order, as far as the contracts allow.
  std::uint32_t catch_up(std::uint64_t rows) noexcept;
  [[nodiscard]] std::uint64_t number_at(std::size_t unit, std::uint64_t row) const noexcept {
    const std::uint64_t since = row - first_rows_[unit];
    return strides_[unit] == 1 ? since : since / strides_[unit];  // avoids the slow division if possible
  }
  /// Serves the release of a periodic module: calls a thread module, or releases a program.
  Instant serve(std::size_t unit, std::uint64_t number, Instant release, Instant now,
                std::uint32_t* wake) noexcept;
  /// Checks the conditions of sporadic modules. `now` is the time after the row's last module.
  std::uint32_t check_conditions(Instant release, Instant now) noexcept;
  void release_immediate() noexcept;
  void make_ready(Sporadic& sporadic, Instant release, std::uint64_t cycle) noexcept;
  /// Calls a thread module that was released at `release`; returns the time after the call.
  Instant call(const Unit& unit, channel::Activity& activity, channel::FlightWriter& flight,
               std::uint64_t number, Instant release, Nanoseconds allowed, Instant start) noexcept;
  /// Records the last body of a program, if it has ended since the last call.
  void record_body(const Unit& unit, std::uint32_t& seen) noexcept;
  void check_budget(const Unit& unit, std::uint64_t number, Nanoseconds took) noexcept;
  void raise_missed(const Unit& unit, std::uint64_t cycle, std::uint64_t releases) noexcept;
  void raise_late(const Unit& unit, std::uint64_t cycle, Nanoseconds by) noexcept;
  void raise(const Unit& unit, ErrorType type, std::uint64_t cycle, const char* text) noexcept;

  schedule::Table table_;
  std::vector<Unit> periodic_;
  std::vector<std::uint64_t> strides_;     // rows between two releases of a periodic unit
  std::vector<std::uint64_t> first_rows_;  // the first row of a periodic unit
  std::uint64_t longest_catch_up_ = 0;     // the most rows that a contract makes up for; 0: none does
  bool only_skip_ = true;                  // every contract is skip
  std::vector<std::uint64_t> made_up_;     // per unit: the first release that is made up for
  std::unique_ptr<Sporadic[]> sporadic_;
  std::size_t sporadic_count_ = 0;
  bool has_immediate_ = false;
  std::vector<std::uint32_t> bodies_seen_;  // of each program, periodic ones first: the last recorded body
  channel::FlightWriter nowhere_;
  channel::FlightWriter& rows_;
  channel::FlightWriter& runs_;  // for sporadic modules
  channel::ExecutorBlock& block_;
  Clock& clock_;
  Nanoseconds basic_;
  std::uint64_t rows_in_table_;
  std::uint64_t row_ = 0;
  std::uint64_t table_row_ = 0;  // row_ modulo rows_in_table_
  Instant release_{};
  std::atomic<Exchange*> asked_{nullptr};  // SYNC: exchange
  std::size_t tried_ = 0;                  // the unit whose body is on trial
  Body* before_ = nullptr;                 // its old body; null: no trial
  std::uint64_t trial_ends_ = 0;           // the trial ends when the unit has this many cycles
};

}  // namespace takt::executor
