#include <takt/recording/series.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace takt::recording {

std::int64_t longest_pause(std::vector<std::int64_t> times, std::int64_t least) {
  constexpr std::int64_t kTimes = 10;
  if (times.size() < 3) return std::max(least, std::numeric_limits<std::int64_t>::max() / 2);
  for (std::size_t i = 0; i + 1 < times.size(); ++i) times[i] = times[i + 1] - times[i];
  times.pop_back();
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return std::max(least, kTimes * *middle);
}

Series::Series(Range range, std::size_t columns, std::int64_t longest_pause_ns)
    : range_(range), columns_(std::max<std::size_t>(columns, 1)), longest_pause_(longest_pause_ns) {}

void Series::add(std::int64_t time_ns, double value, bool missing) {
  if (!std::isfinite(value)) return;
  if (!buckets_.empty() && time_ns < buckets_.back().last.time_ns) return;
  ++count_;
  least_ = std::min(least_, value);
  largest_ = std::max(largest_, value);
  sum_ += value;

  const double length = std::max(1.0, static_cast<double>(range_.last_ns - range_.first_ns));
  const double share = static_cast<double>(time_ns - range_.first_ns) / length;
  const auto column =
      std::min(columns_ - 1, static_cast<std::size_t>(std::max(0.0, share) * static_cast<double>(columns_)));
  const SeriesPoint point{time_ns, value};
  // A gap within two neighbouring columns of pixels cannot be seen.
  const bool begins = buckets_.empty() || time_ns - buckets_.back().last.time_ns > longest_pause_ ||
                      (missing && column > buckets_.back().column + 1);
  if (begins || buckets_.back().column != column) {
    buckets_.push_back({column, begins, point, point, point, point});
    return;
  }
  Bucket& bucket = buckets_.back();
  bucket.last = point;
  if (value < bucket.low.value) bucket.low = point;
  if (value > bucket.high.value) bucket.high = point;
}

std::vector<std::vector<SeriesPoint>> Series::curves() const {
  std::vector<std::vector<SeriesPoint>> curves;
  for (const Bucket& bucket : buckets_) {
    if (bucket.begins) curves.emplace_back();
    std::array points{bucket.first, bucket.low, bucket.high, bucket.last};
    if (points[1].time_ns > points[2].time_ns) std::swap(points[1], points[2]);
    for (const SeriesPoint& point : points) {
      if (curves.back().empty() || curves.back().back() != point) curves.back().push_back(point);
    }
  }
  return curves;
}

}  // namespace takt::recording
