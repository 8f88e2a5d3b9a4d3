// Exact statistics of a series of measured times. The statistics are computed from all values, so each
// percentile is a measured value, not an estimate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace takt::bench {

/// The statistics of a series, in ns (the variance in ns^2). As everywhere in Takt, mean and variance are
/// computed from the signed values, and the other members from the absolute values. Without values, all
/// members are 0.
struct Distribution {
  std::size_t count = 0;
  double mean = 0;
  double variance = 0;
  double min = 0;
  double p50 = 0;
  double p90 = 0;
  double p99 = 0;
  double p999 = 0;
  double max = 0;
};

/// Computes the statistics. Percentiles are nearest-rank: p99 is the smallest value that at least 99 % of the
/// values do not exceed.
Distribution distribution_of(const std::vector<std::int64_t>& values_ns);

/// The nearest-rank percentile of sorted absolute values. `share` is from 0 to 1; 0.99 gives p99. Returns 0
/// if there are no values.
std::int64_t percentile(const std::vector<std::int64_t>& ascending, double share);

/// The absolute values in ascending order.
std::vector<std::int64_t> sorted_sizes(const std::vector<std::int64_t>& values);

}  // namespace takt::bench
