// The scheduler. In each basic period an executor runs the modules of one row of the periodic table, then
// checks the conditions of the sporadic modules.
//
// An executor owns no thread and no clock. Its caller passes the time, so a test or simulation can run the
// same code as the cell at a million cycles per second.
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

/// A module in the tables: its code or its release slot, its counters, and its limits. The members that every
/// release needs are in the first cache line.
struct alignas(64) Unit {
  std::uint32_t index = 0;                ///< the module's index on its device
  Body* body = nullptr;                   ///< the code of a thread module; null for a process module
  channel::ReleaseSlot* slot = nullptr;   ///< the release slot of a process module; null for a thread module
  channel::ModuleBlock* block = nullptr;  ///< the module's counters in shared memory; never null
  Nanoseconds period{};                   ///< for a periodic module: its period
  Nanoseconds deadline{};                 ///< for a sporadic module: its deadline, counted from its release
  Nanoseconds budget{};                   ///< the maximum duration of one run(); 0: no limit
  Nanoseconds interarrival{};  ///< for a sporadic module: minimum time between two releases; 0: no minimum
  /// For a sporadic module: true if events release the module at once (immediate dispatch), false if the
  /// executor checks its condition in each row.
  bool immediate = false;
  bool late_is_error = false;          ///< for a sporadic module: true if a missed deadline is an error
  model::OverrunContract overrun{};    ///< for a periodic module: the reaction to a missed release
  model::BudgetTolerance tolerance{};  ///< the runs over budget that are tolerated
  Exchange* trial = nullptr;  ///< the exchange whose new body is on trial, or null; only the executor uses
                              ///< this
};

/// The flight recorder's writers for the two threads of an executor. A null pointer means that nothing is
/// recorded. The writers must outlive the executor.
struct Flight {
  channel::FlightWriter* rows = nullptr;
  channel::FlightWriter* sporadic = nullptr;
};

class Executor {
 public:
  /// `periodic` and `sporadic` must be in the order of the plan's lists; the executor copies the plan. Only
  /// the constructor allocates memory. `clock` and the blocks must outlive the executor.
  Executor(const schedule::ExecutorPlan& plan, std::vector<Unit> periodic, std::vector<Unit> sporadic,
           channel::ExecutorBlock& block, Clock& clock, Flight flight = {});

  /// Sets the next row to the first one on the grid (T0 + n x basic period) that is due at `now` or later.
  /// After a restart of the host, the rows from block.next_row up to that row count as missed. Do not call
  /// join_grid() for an executor without modules: such an executor has no grid.
  void join_grid(Instant t0, Instant now) noexcept;
  /// Counts the rows whose time is over at `now` as missed. Call this when no row runs any more: the CPU may
  /// have been taken away when the executor was asked to end.
  void leave_grid(Instant now) noexcept;

  /// Returns the time at which the next row is due; always on the grid.
  [[nodiscard]] Instant next_release() const noexcept { return release_; }
  [[nodiscard]] Nanoseconds basic_period() const noexcept { return basic_; }
  /// Returns the number of the next row, counted from T0.
  [[nodiscard]] std::uint64_t next_row() const noexcept { return row_; }

  /// Runs the row that is due at `now`, then checks the conditions of the sporadic modules. `now` must not be
  /// before next_release(). If `now` is one basic period or more after next_release(), the rows in between
  /// count as missed, and the row that contains `now` runs late. Before that row, the executor handles the
  /// missed releases as the overrun contracts of their modules demand. Returns the bits with which the caller
  /// must ring the wake word, to wake process modules and the sporadic thread. A real-time thread may call
  /// this function.
  std::uint32_t run_cycle(Instant now) noexcept;

  /// Releases the modules with immediate dispatch that have unread events. Then runs the ready module with
  /// the earliest absolute deadline; if deadlines are equal, the order of the table decides. Returns false if
  /// no module is ready. Only the thread of the sporadic modules may call this function; another thread may
  /// be in run_cycle() at the same time. A real-time thread may call it.
  bool run_sporadic() noexcept;

  /// Requests the exchange of a module's body. The executor exchanges the body before the next row in which
  /// the module is in the tables. Any thread may call this function. Request the next exchange only after
  /// this one was kept, put back or withdrawn.
  void exchange(Exchange& exchange) noexcept;
  /// Withdraws the requested exchange. Returns false if run_cycle() has already taken up the request.
  bool withdraw() noexcept;

 private:
  enum class Ready : std::uint32_t { no, yes };
  struct Sporadic {
    Unit unit;
    std::atomic<Ready> ready{Ready::no};  // stored after the three members below
    std::int64_t release_ns = 0;
    std::int64_t deadline_ns = 0;
    std::uint64_t cycle = 0;
    /// The earliest time of the next release. Only the thread that releases the module writes this member:
    /// the thread of the rows or, for immediate dispatch, the sporadic thread.
    std::atomic<std::int64_t> not_before_ns{0};
  };

  /// Carries out the requested exchange, if there is one and the module is in the tables. Returns true if a
  /// new body runs from this row on.
  bool begin_exchange() noexcept;
  void check_trial() noexcept;
  void end_trial(Exchange::State state) noexcept;
  void put_back(ErrorType type, std::uint64_t cycle, const char* text) noexcept;
  /// Counts the next `rows` rows as missed, beginning with row_, and moves row_ past them. Treats every
  /// module as if its overrun contract were skip.
  void skip(std::uint64_t rows) noexcept;
  void pass(std::uint64_t rows) noexcept;
  /// Like skip(), but follows the modules' overrun contracts. Returns the bits with which the caller must
  /// ring the wake word.
  std::uint32_t overrun(std::uint64_t rows) noexcept;
  /// Serves missed releases of the last `rows` rows before row_, oldest row first, as far as the modules'
  /// overrun contracts allow it. Returns the bits with which the caller must ring the wake word.
  std::uint32_t catch_up(std::uint64_t rows) noexcept;
  [[nodiscard]] std::uint64_t number_at(std::size_t unit, std::uint64_t row) const noexcept {
    const std::uint64_t since = row - first_rows_[unit];
    return strides_[unit] == 1 ? since : since / strides_[unit];  // avoids the slow division where possible
  }
  /// Serves one release of a periodic module: calls a thread module, or releases a process module. Adds the
  /// bits of the wake word that must be rung to `*wake`. Returns the time after the call.
  Instant serve(std::size_t unit, std::uint64_t number, Instant release, Instant now,
                std::uint32_t* wake) noexcept;
  /// Checks the conditions of the sporadic modules. `now` is the time at which the row's last module ended.
  /// Returns the bits with which the caller must ring the wake word.
  std::uint32_t check_conditions(Instant release, Instant now) noexcept;
  void release_immediate() noexcept;
  void make_ready(Sporadic& sporadic, Instant release, std::uint64_t cycle) noexcept;
  /// Calls run() of a thread module that was released at time `release`. Returns the time after the call.
  Instant call(const Unit& unit, channel::Activity& activity, channel::FlightWriter& flight,
               std::uint64_t number, Instant release, Nanoseconds allowed, Instant start) noexcept;
  /// If a process module has ended a body (the work of one release) since the previous call, records that
  /// body in the flight recorder.
  void record_body(const Unit& unit, std::uint32_t& seen) noexcept;
  void check_budget(const Unit& unit, std::uint64_t number, Nanoseconds took) noexcept;
  void raise_missed(const Unit& unit, std::uint64_t cycle, std::uint64_t releases) noexcept;
  void raise_late(const Unit& unit, std::uint64_t cycle, Nanoseconds by) noexcept;
  void finish(const Unit& unit) noexcept;
  void raise(const Unit& unit, ErrorType type, std::uint64_t cycle, const char* text) noexcept;

  schedule::Table table_;
  std::vector<Unit> periodic_;
  std::vector<std::uint64_t> strides_;     // for each periodic module: rows from one release to the next
  std::vector<std::uint64_t> first_rows_;  // for each periodic module: the first row in which it runs
  // After an overrun, catch_up() serves missed releases of at most this number of rows; 0 if no module has an
  // overrun contract `catch_up`.
  std::uint64_t longest_catch_up_ = 0;
  bool only_skip_ = true;  // true if the overrun contract of every module is `skip`
  // For each periodic module: the number of the first missed release that catch_up() still serves. Earlier
  // missed releases are lost.
  std::vector<std::uint64_t> made_up_;
  std::unique_ptr<Sporadic[]> sporadic_;
  std::size_t sporadic_count_ = 0;
  bool has_immediate_ = false;
  channel::Ticket ticket_{.number = 1};  // the ticket of the next release of a periodic process module
  // For each process module, periodic ones first: the last value of ReleaseSlot::done that record_body() has
  // seen.
  std::vector<std::uint32_t> bodies_seen_;
  channel::FlightWriter nowhere_;
  channel::FlightWriter& rows_;
  channel::FlightWriter& runs_;  // writer of the sporadic thread
  channel::ExecutorBlock& block_;
  Clock& clock_;
  Nanoseconds basic_;
  std::uint64_t rows_in_table_;
  std::uint64_t row_ = 0;
  std::uint64_t table_row_ = 0;  // row_ modulo the number of rows in the table
  Instant release_{};
  std::atomic<Exchange*> asked_{nullptr};  // the requested exchange; null: none
  std::size_t tried_ = 0;                  // index of the periodic module whose body is on trial
  Body* before_ = nullptr;                 // that module's old body; null if there is no trial
  std::uint64_t trial_ends_ = 0;           // the trial ends when that module has this number of cycles
};

}  // namespace takt::executor
