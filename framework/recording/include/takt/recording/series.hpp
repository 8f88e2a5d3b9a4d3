// Reduces any number of samples to a curve with no more points than a picture can show.
//
// To omit samples would lose peaks, and mean values would show values that never occurred. So for each column
// of pixels, the first, last, least and largest values are kept. A line through these values covers the same
// pixels as a line through all samples.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace takt::recording {

struct SeriesPoint {
  std::int64_t time_ns = 0;
  double value = 0;
  bool operator==(const SeriesPoint&) const = default;
};

/// Returns the longest time between two samples that does not count as a gap: ten times the median time
/// between samples, but at least `least`.
std::int64_t longest_pause(std::vector<std::int64_t> times_ns, std::int64_t least);

class Series {
 public:
  struct Range {
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
  };
  /// Begins a new curve after each pause between samples that is longer than `longest_pause_ns`, and after
  /// each gap in which samples were lost, if the gap is visible.
  Series(Range range, std::size_t columns, std::int64_t longest_pause_ns);

  /// Adds a sample. Samples must be added in the order of their times: a sample that is earlier than the
  /// previous sample is ignored. A value that is not finite is also ignored.
  /// `missing` is true if samples were lost before this one.
  void add(std::int64_t time_ns, double value, bool missing = false);

  /// The connected parts of the curve, each with at most four points per column.
  [[nodiscard]] std::vector<std::vector<SeriesPoint>> curves() const;
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double largest() const { return largest_; }
  [[nodiscard]] double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

 private:
  struct Bucket {
    std::size_t column = 0;
    bool begins = false;  ///< true if a new curve begins with this bucket
    SeriesPoint first, last, low, high;
  };

  Range range_;
  std::size_t columns_;
  std::int64_t longest_pause_;
  std::vector<Bucket> buckets_;
  std::uint64_t count_ = 0;
  double least_ = std::numeric_limits<double>::infinity();
  double largest_ = -std::numeric_limits<double>::infinity();
  double sum_ = 0;
};

}  // namespace takt::recording
