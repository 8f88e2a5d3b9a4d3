// Checks, on the events of a simulation, rules that hold for every cell under all circumstances:
//
// - The grid is kept: every row is at T0 + n x period, and starts within its slot.
// - Table order: a row serves each of its modules that is in the tables once, in the table's order.
// - Catching up: releases of missed rows are served before the next row, in the order of the missed rows. A
//   module catches up only if its contract allows this, and only as far as the limit of the contract.
// - A sporadic module runs once each time that it became ready, the module with the earliest deadline first.
//   At least the interarrival time passes between two releases of a module.
// - Every lifecycle step is in the lifecycle table and has the next number. A failed module leaves the tables
//   before it can run again, and its supervisor makes the step `error`.
// - No sample is read twice, torn, out of order, or before it was written.
// - Counters match the events.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/lifecycle/table.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/simulation/event.hpp>
#include "simulated_cell.hpp"

namespace takt::simulation {

/// The final counters of a device, by index.
struct Totals {
  struct OfExecutor {
    std::uint64_t cycles = 0;
    std::uint64_t missed = 0;
    std::uint64_t next_row = 0;
  };
  struct OfModule {
    std::uint64_t cycles = 0;
    std::uint64_t missed = 0;
    std::uint64_t overruns = 0;  ///< overruns that the executor counted
    lifecycle::State state = lifecycle::State::idle;
    std::uint64_t steps = 0;
  };
  std::vector<OfExecutor> executors;
  std::vector<OfModule> modules;
  std::vector<std::uint32_t> unbalanced{};  ///< connections on which a written sample disappeared
};

class Invariants final : public Listener {
 public:
  /// The maximum number of reported violations. Further violations are not reported.
  static constexpr std::size_t kMaxViolations = 50;

  /// `cell` and `plans` must outlive this object.
  Invariants(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans, Instant t0);
  /// Adds a descriptor to which the cell may be updated. Its indices are those of events with version 1.
  void add_version(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans);

  void on_event(const Event& event) override;
  /// Compares the device's final counters with its events. Call close() when the device has ended.
  void close(std::uint32_t device, const Totals& totals);
  /// One line for each violation, with the time since T0.
  [[nodiscard]] const std::vector<std::string>& violations() const noexcept { return violations_; }

 private:
  struct Served {
    std::uint32_t module;
    std::optional<std::uint64_t> number;  // empty if the process module was still in its body
    Instant release;
  };
  struct OfExecutor {
    bool has_joined = false;
    std::uint64_t first_row = 0;  // a device that is restored begins later than at row 0
    std::uint64_t next_row = 0;
    std::uint64_t cycles = 0;
    bool in_row = false;
    std::uint64_t woke_for = 0;
    Instant woke_at{};
    std::vector<Served> served{};
    std::optional<std::uint32_t> runs{};      // the module that runs in the row
    std::optional<std::uint32_t> sporadic{};  // the module that runs on the sporadic thread
  };
  struct OfModule {
    bool in_tables = false;
    std::uint64_t changes = 0;  // number of changes of in_tables
    bool was_in = false;        // value of in_tables when the module's executor woke
    std::uint64_t changes_then = 0;
    std::uint64_t cycles = 0;
    std::uint64_t busy = 0;
    std::uint64_t missed = 0;
    std::uint64_t out = 0;    // number of releases that were due while the module was out of the tables
    std::uint64_t twice = 0;  // number of releases counted as both served and missed, because a crash cut
                              // their row short
    lifecycle::State state = lifecycle::State::idle;
    lifecycle::State before_error = lifecycle::State::start;
    std::uint64_t steps = 0;
    bool failed = false;  // the module's run failed, so the module must leave the tables next
    bool raised = false;  // the module left the tables with an error, so the step `error` must follow
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
    std::size_t version = 0;
    Instant t0{};
    std::vector<OfExecutor> executors{};
    std::vector<OfModule> modules{};
  };
  struct Version {
    const model::Cell* cell;
    const std::vector<schedule::DevicePlan>* plans;
    std::vector<std::uint32_t> numbers;  // of the connections
  };

  void violated(const Event& event, const std::string& what);
  void on_row(const Event& event, OfDevice& device);
  void check_row(const Event& event, OfDevice& device, const schedule::ExecutorPlan& plan);
  std::vector<Served>::const_iterator check_made_up(const Event& event, OfDevice& device,
                                                    const schedule::ExecutorPlan& plan);
  [[nodiscard]] bool has_pending_releases(std::uint32_t device, std::uint32_t module) const;
  void on_module(const Event& event, OfDevice& device);
  void on_run(const Event& event, OfDevice& device);
  void on_step(const Event& event, OfModule& module);
  void on_sample(const Event& event);
  void count_missed(OfDevice& device, const schedule::ExecutorPlan& plan, std::uint32_t on,
                    std::uint64_t from, std::uint64_t to, bool as_woken);
  [[nodiscard]] static std::uint64_t first_row(const OfDevice& device, std::size_t executor,
                                               const Totals& totals);
  [[nodiscard]] Nanoseconds period_of(std::uint32_t device, std::uint32_t module) const;
  [[nodiscard]] std::uint32_t executor_of(std::uint32_t device, std::uint32_t module) const;

  [[nodiscard]] OfDevice as_new(std::size_t device, std::size_t version) const;
  [[nodiscard]] const model::Cell& cell_of(std::uint32_t device) const {
    return *versions_[devices_[device].version].cell;
  }
  [[nodiscard]] const model::Device& model_of(std::uint32_t device) const {
    return cell_of(device).devices[device];
  }
  [[nodiscard]] const schedule::DevicePlan& plan_of(std::uint32_t device) const {
    return (*versions_[devices_[device].version].plans)[device];
  }

  Instant t0_;
  std::vector<Version> versions_;
  ConnectionNumbers numbers_;
  std::vector<OfConnection> connections_;  // by number
  std::vector<OfDevice> devices_;
  std::vector<std::string> violations_;
};

}  // namespace takt::simulation
