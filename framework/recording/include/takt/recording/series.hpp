// A curve of so many samples as come, with no more points than a picture shows.
//
// Leaving out samples loses peaks, and means invent values that never were. So of each column of pixels the
// first, the last, the least and the largest value are kept: a line through them covers the same pixels as
// one through all.
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

/// A gap between samples that is longer than ten times what is usual: the median of the times between them.
/// Never shorter than `least`.
std::int64_t longest_pause(std::vector<std::int64_t> times_ns, std::int64_t least);

class Series {
 public:
  struct Range {
    std::int64_t first_ns = 0;
    std::int64_t last_ns = 0;
  };
  /// After a pause that is longer the curve begins anew.
  Series(Range range, std::size_t columns, std::int64_t longest_pause_ns);

  /// In the order of time; one that is before the last is left out, as is what is no number.
  void add(std::int64_t time_ns, double value);

  /// What is connected, each with at most four points a column.
  [[nodiscard]] std::vector<std::vector<SeriesPoint>> curves() const;
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double least() const { return least_; }
  [[nodiscard]] double largest() const { return largest_; }
  [[nodiscard]] double mean() const { return count_ == 0 ? 0 : sum_ / static_cast<double>(count_); }

 private:
  struct Bucket {
    std::size_t column = 0;
    bool begins = false;  ///< a curve
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
