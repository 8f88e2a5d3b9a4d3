// The pictures of Figures 12 to 19 of the paper, of what was measured here: how large the jitter was at each
// time, and how often it was how large. Sizes on a logarithmic scale, because what matters spans four
// decades: tens of nanoseconds as a rule, a millisecond where the machine was taken away.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "modules/recording.hpp"

namespace takt::bench {

/// CSS of the classes that the pictures use, beside those of every picture; light, dark.
extern const char* const kChartColours;
extern const char* const kDarkChartColours;

/// For each stretch of time, from the smallest to the largest size, and the median. `served` in the order of
/// time. For a page of HTML.
std::string jitter_over_time(const std::string& title, const std::vector<Served>& served, Nanoseconds period);

/// The share of the releases in each class of sizes, ten classes a decade; shares on a logarithmic scale too.
/// The bare loop's as a line. For a page of HTML.
std::string jitter_histogram(const std::string& title, const std::vector<Served>& served,
                             const std::vector<std::int64_t>& bare);

/// How many of the sizes fall in each class, of which the first holds all that is below kLeastSize. As many
/// classes as the largest size needs.
std::vector<std::size_t> classes_of(const std::vector<std::int64_t>& values);
inline constexpr double kLeastSize = 10;  // ns
inline constexpr int kClassesOfADecade = 10;

}  // namespace takt::bench
