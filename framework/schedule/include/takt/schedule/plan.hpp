// What each executor of a device has to do: the tables of the paper's Figures 3 and 4, one pair an executor.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/table.hpp>

namespace takt::schedule {

/// Modules are named by their index in model::Device::modules.
struct ExecutorPlan {
  std::uint32_t executor = 0;  ///< index in model::Device::executors
  Nanoseconds basic_period{};  ///< 0 when it has no module; of a sporadic-only one as rows() says
  Nanoseconds macro_period{};
  Table table;                          ///< rows of indices into `periodic`
  std::vector<std::uint32_t> periodic;  ///< modules, in the order of the file
  std::vector<Nanoseconds> offsets;     ///< of the periodic modules' first releases from T0
  std::vector<std::uint32_t> sporadic;  ///< modules, by priority, then in the order of the file
  int priority = 80;                    ///< SCHED_FIFO, 2 to 98

  /// How many rows one macro period has. An executor that has sporadic modules only checks their conditions
  /// twice in the shortest of their deadlines: one empty row, which lasts half that deadline, but at least 1
  /// ns.
  [[nodiscard]] std::size_t rows() const noexcept;
  /// The modules of a row, in the order in which they run. row < rows(). Allocates.
  [[nodiscard]] std::vector<std::uint32_t> row(std::size_t row) const;
  /// The sum of the budgets of a row's thread modules, at most 2^63 - 1 ns, and whether all of them state
  /// one.
  struct Load {
    Nanoseconds budget{};
    bool complete = true;
  };
  [[nodiscard]] Load load(const model::Device& device, std::size_t row) const;
};

/// Of a periodic module of this executor, by its index on the device.
Nanoseconds offset_of(const ExecutorPlan& plan, std::uint32_t module);

struct DevicePlan {
  std::vector<ExecutorPlan> executors;      ///< one for each of the device's, in its order
  std::vector<std::uint32_t> non_realtime;  ///< by priority, then in the order of the file
};

/// Executors with priority="auto" get theirs by their basic periods, the shortest the highest: from
/// kHighestAuto down in steps of four, since sporadic modules and programs run one to three below their
/// executor; equal periods have equal ones, and the last step is for all that are left.
inline constexpr int kHighestAuto = 80;

/// Fails with one problem for each executor whose table passes the limits, each executor with rows whose
/// budgets do not fit the basic period (the fullest is named and the others counted), and each module whose
/// budget exceeds its period or deadline. Only the budgets of thread modules fill a row: process modules run
/// on other cores. Every problem is at the line of a module. The cell has passed model::validate, and the
/// device is one of its own. Allocates.
Result<DevicePlan> plan(const model::Cell& cell, const model::Device& device);

/// The same for all devices; every problem of every device.
Result<std::vector<DevicePlan>> plan(const model::Cell& cell);

}  // namespace takt::schedule
