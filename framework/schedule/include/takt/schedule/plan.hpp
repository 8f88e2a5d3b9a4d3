// The tables of each executor of a device: the periodic table of the paper's Figure 3 and the sporadic list
// of Figure 4.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/table.hpp>

namespace takt::schedule {

/// The plan of one executor. Modules are indices in model::Device::modules.
struct ExecutorPlan {
  std::uint32_t executor = 0;  ///< index in model::Device::executors
  Nanoseconds basic_period{};  ///< 0 without modules; with only sporadic modules see rows()
  Nanoseconds macro_period{};
  Table table;                          ///< rows of indices into `periodic`
  std::vector<std::uint32_t> periodic;  ///< modules, in the order of the descriptor
  std::vector<Nanoseconds> offsets;     ///< first release of each periodic module, from T0
  std::vector<std::uint32_t> sporadic;  ///< modules, by priority, then in the order of the descriptor
  int priority = 80;                    ///< SCHED_FIFO, 2 to 98

  /// The number of rows of one macro period. An executor with only sporadic modules has one empty row, which
  /// lasts half of the shortest deadline, at least 1 ns. So it checks each condition twice per deadline.
  [[nodiscard]] std::size_t rows() const noexcept;
  /// The modules of a row, in the order in which they run. row < rows(). Allocates.
  [[nodiscard]] std::vector<std::uint32_t> row(std::size_t row) const;
  /// The load of a row: the sum of the budgets of its thread modules, at most 2^63 - 1 ns, and whether all of
  /// these modules have a budget.
  struct Load {
    Nanoseconds budget{};
    bool complete = true;
  };
  [[nodiscard]] Load load(const model::Device& device, std::size_t row) const;
};

/// The offset of a periodic module of this executor, by its index on the device.
Nanoseconds offset_of(const ExecutorPlan& plan, std::uint32_t module);

struct DevicePlan {
  std::vector<ExecutorPlan> executors;      ///< one for each executor of the device, in the same order
  std::vector<std::uint32_t> non_realtime;  ///< by priority, then in the order of the descriptor
};

/// The highest priority of executors with priority="auto". The executor with the shortest basic period gets
/// it; longer periods follow in steps of four, because sporadic modules and programs run one to three below
/// their executor. Equal periods get equal priorities. The lowest step is shared by all remaining executors.
inline constexpr int kHighestAuto = 80;

/// Plans a device. Fails with one problem for each of these, at the line of a module:
/// - an executor whose table exceeds the limits,
/// - an executor with rows whose budgets exceed the basic period (names the fullest row and counts the
/// others),
/// - a module whose budget exceeds its period or deadline.
/// Only the budgets of thread modules fill a row: process modules run on other CPUs. The device must be one
/// of the cell, and the cell must have passed model::validate(). Allocates.
Result<DevicePlan> plan(const model::Cell& cell, const model::Device& device);

/// Plans all devices of the cell. Fails with the problems of all devices.
Result<std::vector<DevicePlan>> plan(const model::Cell& cell);

}  // namespace takt::schedule
