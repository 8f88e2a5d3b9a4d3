// The periodic table of the paper's Figure 3: the modules that are due at each multiple of the basic period.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::schedule {

/// The maximum number of entries. A table has one entry for each run of each module in a macro period.
inline constexpr std::size_t kMaxEntries = 1'000'000;
/// The maximum number of rows. In a table with even more rows, most rows would be empty.
inline constexpr std::size_t kMaxRows = 10'000'000;

struct Task {
  Nanoseconds period{};
  int priority = 0;  ///< the task with the lowest number runs first; tasks with equal numbers run in the
                     ///< order of the input
  std::string_view name{};  ///< only for messages, which use the task's index if it has no name
  Nanoseconds offset{};     ///< time from the first row to the task's first release; at least 0 and less than
                            ///< the period
};

/// The two tasks that make a table long: the pair of different periods that has the largest least common
/// multiple. If there are several such pairs, this is the pair with the shortest period. If several tasks
/// have one of these periods, this is the first of them. Both members are 0 if all periods are equal. All
/// periods must be positive.
struct PeriodPair {
  std::uint32_t shorter = 0;
  std::uint32_t longer = 0;
};
PeriodPair longest_pair(std::span<const Task> tasks);

/// The rows of a table. Each row contains indices into the tasks from which the table was built. Any thread
/// may read a table, including real-time threads.
class Table {
 public:
  using Index = std::uint32_t;

  /// Builds the table of the tasks. Fails with one problem for each period that is not positive, and for each
  /// offset that is negative or not less than its period. Also fails if the table would exceed kMaxEntries or
  /// kMaxRows, or if its macro period in ns would not fit in 63 bits; then the problem names the two periods
  /// that cause this. If there are no tasks, returns an empty table with periods of 0. Allocates memory. The
  /// running time is proportional to the number of entries plus rows.
  static Result<Table> build(std::span<const Task> tasks);

  /// The greatest common divisor of the periods and offsets.
  [[nodiscard]] Nanoseconds basic_period() const noexcept { return basic_; }
  /// The least common multiple of the periods.
  [[nodiscard]] Nanoseconds macro_period() const noexcept { return macro_; }
  /// The macro period divided by the basic period.
  [[nodiscard]] std::size_t rows() const noexcept { return offsets_.size() - 1; }
  [[nodiscard]] std::size_t entries() const noexcept { return entries_.size(); }
  /// The tasks that are due at `row` x basic period, in the order of priority. `row` must be less than
  /// rows().
  [[nodiscard]] std::span<const Index> row(std::size_t row) const noexcept {
    return std::span{entries_}.subspan(offsets_[row], offsets_[row + 1] - offsets_[row]);
  }

 private:
  Nanoseconds basic_{};
  Nanoseconds macro_{};
  std::vector<Index> entries_;
  std::vector<Index> offsets_{0};  // contains rows() + 1 elements
};

}  // namespace takt::schedule
