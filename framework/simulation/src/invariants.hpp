// What must hold of a cell whatever happens to it, checked on the events of a simulation:
//
// - The grid is never left: every row is at T0 + n x period, and starts within its slot.
// - Table order: a row serves each module that it names and that is in the tables once, in the table's order.
// - Releases of rows that were missed are made up before the next row, in their order, by whose contract says
//   so, and no more than its limit.
// - Sporadic modules run once for each time they were ready, the earliest deadline first, and no sooner after
//   another than their interarrival time.
// - Every step is one of the lifecycle's table and has the next number; whoever failed is out of the tables
//   before anything else of it runs, and its supervisor takes the step `error`.
// - No sample is read twice, torn, out of order, or before it was written.
// - Counters add up to what happened.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/lifecycle/table.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/simulation/event.hpp>

namespace takt::simulation {

/// What a device has counted, by index, when it has ended.
struct Totals {
  struct OfExecutor {
    std::uint64_t cycles = 0;
    std::uint64_t missed = 0;
    std::uint64_t next_row = 0;
  };
  struct OfModule {
    std::uint64_t cycles = 0;
    std::uint64_t missed = 0;
    std::uint64_t overruns = 0;  ///< that the executor counted
    lifecycle::State state = lifecycle::State::idle;
    std::uint64_t steps = 0;
  };
  std::vector<OfExecutor> executors;
  std::vector<OfModule> modules;
  std::vector<std::uint32_t> unbalanced{};  ///< connections: a sample was written and is nowhere
};

class Invariants final : public Listener {
 public:
  /// No more are told.
  static constexpr std::size_t kMaxViolations = 50;

  /// The cell and its plans outlive this.
  Invariants(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans, Instant t0);

  void hear(const Event& event) override;
  /// The device has ended.
  void close(std::uint32_t device, const Totals& totals);
  /// One line each, with the time since T0; empty when all held.
  [[nodiscard]] const std::vector<std::string>& violations() const noexcept { return violations_; }

 private:
  struct Served {
    std::uint32_t module;
    std::optional<std::uint64_t> number;  // none: busy
    Instant release;
  };
  struct OfExecutor {
    std::uint64_t next_row = 0;
    std::uint64_t cycles = 0;
    bool in_row = false;
    std::uint64_t woke_for = 0;
    Instant woke_at{};
    std::vector<Served> served{};
    std::optional<std::uint32_t> runs{};      // in a row
    std::optional<std::uint32_t> sporadic{};  // on the other thread
  };
  struct OfModule {
    bool in_tables = false;
    std::uint64_t changes = 0;  // of that
    bool was_in = false;        // when its executor woke
    std::uint64_t changes_then = 0;
    std::uint64_t cycles = 0;
    std::uint64_t busy = 0;
    std::uint64_t missed = 0;
    std::uint64_t out = 0;    // releases that were due while it was not in the tables
    std::uint64_t twice = 0;  // served in a row that a crash cut short, which counts as missed
    lifecycle::State state = lifecycle::State::idle;
    lifecycle::State before_error = lifecycle::State::start;
    std::uint64_t steps = 0;
    bool failed = false;  // is to be taken out
    bool raised = false;  // the step `error` is to come
    std::optional<Instant> ready_until{};
    std::uint64_t ready_changes = 0;
    std::optional<Instant> last_ready{};
  };
  struct OfConnection {
    std::uint64_t wrote = 0;
    std::uint64_t read = 0;
    std::uint64_t arrived = 0;
  };
  struct OfDevice {
    std::vector<OfExecutor> executors;
    std::vector<OfModule> modules;
  };

  void violated(const Event& event, const std::string& what);
  void hear_row(const Event& event, OfDevice& device);
  void check_row(const Event& event, OfDevice& device, const schedule::ExecutorPlan& plan);
  std::vector<Served>::const_iterator check_made_up(const Event& event, OfDevice& device,
                                                    const schedule::ExecutorPlan& plan);
  [[nodiscard]] bool is_owed(std::uint32_t device, std::uint32_t module) const;
  void hear_module(const Event& event, OfDevice& device);
  void hear_run(const Event& event, OfDevice& device);
  void hear_step(const Event& event, OfModule& module);
  void hear_sample(const Event& event);
  void count_missed(OfDevice& device, const schedule::ExecutorPlan& plan, std::uint32_t on,
                    std::uint64_t from, std::uint64_t to, bool as_woken);
  [[nodiscard]] Nanoseconds period_of(std::uint32_t device, std::uint32_t module) const;
  [[nodiscard]] std::uint32_t executor_of(std::uint32_t device, std::uint32_t module) const;

  const model::Cell& cell_;
  const std::vector<schedule::DevicePlan>& plans_;
  Instant t0_;
  std::vector<OfDevice> devices_;
  std::vector<OfConnection> connections_;
  std::vector<std::string> violations_;
};

}  // namespace takt::simulation
