// The periodic scheduling table of the paper's Figure 3: the modules that are due at each multiple of the
// basic period.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::schedule {

/// The maximum number of entries: the modules in all rows of one macro period.
inline constexpr std::size_t kMaxEntries = 1'000'000;
/// The maximum number of rows; in a table with more, most rows would be empty.
inline constexpr std::size_t kMaxRows = 10'000'000;

struct Task {
  Nanoseconds period{};
  int priority = 0;         ///< the lowest value goes first; ties in the order of the input
  std::string_view name{};  ///< for messages only; a task without a name is called by its index
  Nanoseconds offset{};     ///< of its first release from the first row, at least 0 and less than its period
};

/// The two tasks that make a table long: the two different periods with the largest least common multiple. Of
/// several such pairs, the pair with the shortest period is taken. Of several tasks with the same period, the
/// first is taken. Both are 0 if all periods are equal. Every period must be positive.
struct PeriodPair {
  std::uint32_t shorter = 0;
  std::uint32_t longer = 0;
};
PeriodPair longest_pair(std::span<const Task> tasks);

/// Rows of indices into the tasks that the table was built from. Any thread may read it, including real-time
/// threads.
class Table {
 public:
  using Index = std::uint32_t;

  /// Fails with one problem for each period that is not positive and each offset that is not within its
  /// period. Also fails if the table would exceed the limits above, or if its macro period would not fit in
  /// 63 bits (ns). The problem names the two periods that cause this. Without tasks, returns an empty table
  /// with periods of 0. Takes time proportional to the entries plus the rows; allocates.
  static Result<Table> build(std::span<const Task> tasks);

  /// The greatest common divisor of the periods and offsets.
  [[nodiscard]] Nanoseconds basic_period() const noexcept { return basic_; }
  [[nodiscard]] Nanoseconds macro_period() const noexcept { return macro_; }       ///< least common multiple
  [[nodiscard]] std::size_t rows() const noexcept { return offsets_.size() - 1; }  ///< macro / basic
  [[nodiscard]] std::size_t entries() const noexcept { return entries_.size(); }
  /// The tasks due at row x basic period, by priority. row < rows().
  [[nodiscard]] std::span<const Index> row(std::size_t row) const noexcept {
    return std::span{entries_}.subspan(offsets_[row], offsets_[row + 1] - offsets_[row]);
  }

 private:
  Nanoseconds basic_{};
  Nanoseconds macro_{};
  std::vector<Index> entries_;
  std::vector<Index> offsets_{0};  // rows() + 1 of them
};

}  // namespace takt::schedule
