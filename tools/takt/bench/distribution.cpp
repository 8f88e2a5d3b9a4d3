#include "distribution.hpp"

#include <algorithm>
#include <cmath>

namespace takt::bench {

std::vector<std::int64_t> sorted_sizes(const std::vector<std::int64_t>& values) {
  std::vector<std::int64_t> sizes;
  sizes.reserve(values.size());
  for (const std::int64_t value : values) sizes.push_back(value < 0 ? -value : value);
  std::sort(sizes.begin(), sizes.end());
  return sizes;
}

std::int64_t percentile(const std::vector<std::int64_t>& ascending, double share) {
  if (ascending.empty()) return 0;
  // Subtract a little, because 0.99 is not exact as a double: 0.99 of 100 values must be rank 99, not 100.
  const double rank = std::ceil(share * static_cast<double>(ascending.size()) - 1e-6);
  const auto place = static_cast<std::size_t>(std::max(1.0, rank)) - 1;
  return ascending[std::min(place, ascending.size() - 1)];
}

Distribution distribution_of(const std::vector<std::int64_t>& values_ns) {
  if (values_ns.empty()) return {};
  const auto count = static_cast<double>(values_ns.size());
  double sum = 0;
  for (const std::int64_t value : values_ns) sum += static_cast<double>(value);
  const double mean = sum / count;
  // Compute the variance in a second pass. In a single pass, it would be the difference of two large numbers,
  // which is not accurate.
  double squares = 0;
  for (const std::int64_t value : values_ns) {
    const double from_mean = static_cast<double>(value) - mean;
    squares += from_mean * from_mean;
  }
  const std::vector<std::int64_t> sizes = sorted_sizes(values_ns);
  const auto at = [&sizes](double share) { return static_cast<double>(percentile(sizes, share)); };
  return {.count = sizes.size(),
          .mean = mean,
          .variance = squares / count,
          .min = static_cast<double>(sizes.front()),
          .p50 = at(0.5),
          .p90 = at(0.9),
          .p99 = at(0.99),
          .p999 = at(0.999),
          .max = static_cast<double>(sizes.back())};
}

}  // namespace takt::bench
