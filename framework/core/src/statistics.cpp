#include <takt/core/statistics.hpp>

#include <algorithm>

namespace takt {

std::int64_t HistogramScale::lower(std::size_t bucket) noexcept {
  if (bucket < 32) return static_cast<std::int64_t>(bucket);
  const std::size_t octave = (bucket - 32) / 16 + 5;
  const std::size_t step = (bucket - 32) % 16;
  return static_cast<std::int64_t>((16 + step) << (octave - 4));
}

double StatisticsSnapshot::quantile(double q) const noexcept {
  std::uint64_t total = 0;
  for (std::uint64_t n : buckets) total += n;
  if (total == 0) return 0;
  const double rank = q * static_cast<double>(total);
  double below = 0;
  for (std::size_t i = 0; i < buckets.size(); ++i) {
    const auto here = static_cast<double>(buckets[i]);
    if (here > 0 && below + here >= rank) {
      const auto from = static_cast<double>(HistogramScale::lower(i));
      const auto to = static_cast<double>(HistogramScale::lower(i + 1));
      const double inside = i < 32 ? from : from + (to - from) * (rank - below) / here;
      return std::clamp(inside, static_cast<double>(min), static_cast<double>(max));
    }
    below += here;
  }
  return static_cast<double>(max);
}

StatisticsSnapshot Statistics::read() const noexcept {
  constexpr auto acquire = std::memory_order_acquire;
  constexpr int kTries = 1000;

  StatisticsSnapshot snapshot;
  for (int i = 0; i < kTries; ++i) {
    const std::uint64_t before = sequence_.load(acquire);  // pairs with the stores in record()
    snapshot.count = count_.load(acquire);
    const auto sum = static_cast<double>(sum_.load(acquire));
    const double sum_of_squares = sum_of_squares_.load(acquire);
    snapshot.min = min_.load(acquire);
    snapshot.max = max_.load(acquire);
    for (std::size_t b = 0; b < buckets_.size(); ++b) snapshot.buckets[b] = buckets_[b].load(acquire);

    const auto n = static_cast<double>(snapshot.count);
    snapshot.mean = snapshot.count == 0 ? 0 : sum / n;
    snapshot.variance =
        snapshot.count == 0 ? 0 : std::max(0.0, sum_of_squares / n - snapshot.mean * snapshot.mean);
    if (before % 2 == 0 && sequence_.load(std::memory_order_relaxed) == before) break;
  }
  return snapshot;
}

}  // namespace takt
