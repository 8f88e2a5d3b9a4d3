// Exact statistics of a series of measured times. All values are kept, so a percentile is a measured value,
// not an estimate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace takt::bench {

/// All members are in ns (variance: ns^2). As everywhere in Takt, mean and variance are of the signed values;
/// the other members are of the absolute values. All are 0 if there are no values.
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

/// Percentiles by the nearest rank: p99 is the smallest value that at least 99 of 100 do not exceed.
Distribution distribution_of(const std::vector<std::int64_t>& values_ns);

/// The percentile, by the nearest rank, of sorted absolute values. `share` is from 0 to 1. Returns 0 if there
/// are no values.
std::int64_t percentile(const std::vector<std::int64_t>& ascending, double share);

/// The absolute values, sorted.
std::vector<std::int64_t> sorted_sizes(const std::vector<std::int64_t>& values);

}  // namespace takt::bench
