// Draws the measurements as in Figures 12 to 19 of the paper: the jitter over time, and its histogram. Scales
// are logarithmic, because the jitter spans many decades: usually tens of nanoseconds, but a millisecond if
// the machine lost its CPU.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "modules/recording.hpp"

namespace takt::bench {

/// The CSS of the charts for the light and the dark theme, in addition to the CSS of Canvas.
extern const char* const kChartColours;
extern const char* const kDarkChartColours;

/// Draws the range and the median of the absolute jitter for each interval of time. `served` is sorted by
/// time. For an HTML page.
std::string jitter_over_time(const std::string& title, const std::vector<Served>& served, Nanoseconds period);

/// Draws the share of the releases in each class of absolute jitter, with ten classes per decade and a
/// logarithmic scale of shares. The bare loop is drawn as a line. For an HTML page.
std::string jitter_histogram(const std::string& title, const std::vector<Served>& served,
                             const std::vector<std::int64_t>& bare);

/// The number of values in each class, by absolute value. The first class has all values below kLeastSize.
/// There are as many classes as the largest value needs.
std::vector<std::size_t> classes_of(const std::vector<std::int64_t>& values);
inline constexpr double kLeastSize = 10;  // ns
inline constexpr int kClassesOfADecade = 10;

}  // namespace takt::bench
