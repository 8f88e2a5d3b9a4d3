// Draws measurements like Figures 12 to 19 of the paper: the jitter over time, and its histogram. The scales
// are logarithmic, because jitter is usually tens of nanoseconds, but may be a millisecond if a virtual
// machine loses its CPU.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/time.hpp>

#include "modules/recording.hpp"

namespace takt::bench {

/// The CSS of the charts, for the light and the dark theme. A page also needs the CSS of Canvas.
extern const char* const kChartColours;
extern const char* const kDarkChartColours;

/// Draws the range and the median of the absolute jitter over time, as SVG for an HTML page. `served` must be
/// sorted by time.
std::string jitter_over_time(const std::string& title, const std::vector<Served>& served, Nanoseconds period);

/// Draws the histogram of the absolute jitter, as SVG for an HTML page. A histogram has ten classes per
/// decade. The scale for the share of releases in a class is logarithmic. The bare loop is drawn as a line.
std::string jitter_histogram(const std::string& title, const std::vector<Served>& served,
                             const std::vector<std::int64_t>& bare);

/// Counts the absolute values in each class of the histogram. The first class has all values below
/// kLeastSize. The result has as many classes as the largest value needs.
std::vector<std::size_t> classes_of(const std::vector<std::int64_t>& values);
inline constexpr double kLeastSize = 10;  // ns, upper end of the first class
inline constexpr int kClassesOfADecade = 10;

}  // namespace takt::bench
