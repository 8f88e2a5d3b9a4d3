// The tables of each executor of a device: the periodic table of the paper's Figure 3, and the sporadic list
// of its Figure 4.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/table.hpp>

namespace takt::schedule {

/// The plan of one executor. Modules are given as indices into model::Device::modules.
struct ExecutorPlan {
  std::uint32_t executor = 0;  ///< index into model::Device::executors
  Nanoseconds basic_period{};  ///< 0 if the executor has no modules; see rows() if it has only sporadic
                               ///< modules
  Nanoseconds macro_period{};
  Table table;                          ///< rows of indices into `periodic`
  std::vector<std::uint32_t> periodic;  ///< the periodic modules, in the order of the descriptor
  std::vector<Nanoseconds> offsets;     ///< the first release of each periodic module, counted from T0
  std::vector<std::uint32_t> sporadic;  ///< the sporadic modules, by priority, then in the order of the
                                        ///< descriptor
  int priority = 80;                    ///< priority for SCHED_FIFO, 2 to 98

  /// The number of rows of one macro period. An executor with only sporadic modules has one empty row, which
  /// lasts half of the shortest deadline, but at least 1 ns. So the executor checks each condition at least
  /// twice within its deadline.
  [[nodiscard]] std::size_t rows() const noexcept;
  /// The modules of a row, in the order in which they run. `row` must be less than rows(). Allocates memory.
  [[nodiscard]] std::vector<std::uint32_t> row(std::size_t row) const;
  /// The load of a row: the sum of the budgets of its thread modules, limited to 2^63 - 1 ns, and whether all
  /// of these modules have a budget.
  struct Load {
    Nanoseconds budget{};
    bool complete = true;
  };
  [[nodiscard]] Load load(const model::Device& device, std::size_t row) const;
};

/// Returns the offset of a periodic module of this executor. `module` is the module's index on the device.
Nanoseconds offset_of(const ExecutorPlan& plan, std::uint32_t module);

struct DevicePlan {
  std::vector<ExecutorPlan> executors;      ///< one plan for each executor of the device, in the same order
  std::vector<std::uint32_t> non_realtime;  ///< the non-real modules, by priority, then in the order of the
                                            ///< descriptor
};

/// The highest priority of an executor with priority="auto". The executor with the shortest basic period gets
/// this priority. Longer periods follow in steps of ten, because the process modules and sporadic modules of
/// an executor run one to nine priorities below their executor (levels.hpp). Executors with equal periods get
/// equal priorities. If there are more periods than steps, the remaining executors share the lowest step.
inline constexpr int kHighestAuto = 80;

/// Plans a device. Fails with one problem for each of these mistakes, at the line of a module:
/// - an executor whose table exceeds the limits,
/// - an executor with rows whose budgets exceed the basic period; the problem names the fullest row and gives
///   the number of such rows,
/// - a module whose budget exceeds its period or deadline.
/// Only the budgets of thread modules count for a row, because process modules run on other CPUs. The device
/// must be one of the cell, and the cell must have passed model::validate(). Allocates.
Result<DevicePlan> plan(const model::Cell& cell, const model::Device& device);

/// Plans all devices of the cell. Fails with the problems of all its devices.
Result<std::vector<DevicePlan>> plan(const model::Cell& cell);

}  // namespace takt::schedule
