// The periodic scheduling table of the paper's Figure 3: which modules are due at which multiple of the basic period.
#pragma once

#include <cstdint>
#include <span>
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
  int priority = 0;  ///< the lowest value goes first; ties in the order of the input
};

/// Rows of indices into the tasks it was built from. Reading is for any thread, also real-time ones.
class Table {
 public:
  using Index = std::uint32_t;

  /// Fails when a period is not positive, or when the table would pass the limits above, saying which two periods make it
  /// so. No tasks: an empty table with periods of 0.
  static Result<Table> build(std::span<const Task> tasks);

  [[nodiscard]] Nanoseconds basic_period() const noexcept { return basic_; }  ///< greatest common divisor
  [[nodiscard]] Nanoseconds macro_period() const noexcept { return macro_; }  ///< least common multiple
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
