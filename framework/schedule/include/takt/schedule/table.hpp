// The periodic scheduling table of the paper's Figure 3: which modules are due at which multiple of the basic
// period.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::schedule {

/// More than this many entries (modules in rows, summed over one macro period) are refused.
inline constexpr std::size_t kMaxEntries = 1'000'000;
/// Nor may a table have more rows than this, most of which would be empty.
inline constexpr std::size_t kMaxRows = 10'000'000;

struct Task {
  Nanoseconds period{};
  int priority = 0;         ///< the lowest value goes first; ties in the order of the input
  std::string_view name{};  ///< for messages only; without one a task is called by its index
  Nanoseconds offset{};     ///< of its first release from the first row, 0 to below its period
};

/// The two tasks that make a table long: no other two periods that differ have a larger least common
/// multiple, and among those that have the same one, these have the shortest period. The first has the
/// shorter one. Both are the first of their period; both are 0 when all tasks have the same. Every period is
/// positive.
struct PeriodPair {
  std::uint32_t shorter = 0;
  std::uint32_t longer = 0;
};
PeriodPair longest_pair(std::span<const Task> tasks);

/// Rows of indices into the tasks it was built from. Reading is for any thread, also real-time ones.
class Table {
 public:
  using Index = std::uint32_t;

  /// Fails when a period is not positive or an offset not within it (one problem each), or when the table
  /// would pass the limits above or its macro period 2^63 - 1 ns, saying which two periods make it so. No
  /// tasks: an empty table with periods of 0. Takes time for the entries and the rows, not for their product;
  /// allocates.
  static Result<Table> build(std::span<const Task> tasks);

  [[nodiscard]] Nanoseconds basic_period() const noexcept {
    return basic_;
  }  ///< greatest common divisor of periods and offsets
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
