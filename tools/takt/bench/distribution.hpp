// What a series of measured times comes to, exactly: every value was kept, so a percentile is one of them and
// no estimate.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace takt::bench {

/// In nanoseconds (variance: ns^2). As everywhere in Takt, mean and variance are of the signed values and all
/// others of their size. All 0 where there was no value.
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

/// The same percentile of sizes that are ascending; `share` from 0 to 1. 0 where there is none.
std::int64_t percentile(const std::vector<std::int64_t>& ascending, double share);

/// The sizes of the values, ascending.
std::vector<std::int64_t> sorted_sizes(const std::vector<std::int64_t>& values);

}  // namespace takt::bench
