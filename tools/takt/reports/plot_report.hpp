// Draws curves as SVG: a panel for each field, with a common time axis.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace takt::tool {

struct PlotPoint {
  double time = 0;  ///< s since the beginning
  double value = 0;
};

struct PlotSeries {
  std::string name;
  std::vector<std::vector<PlotPoint>>
      curves{};  ///< each is drawn as one line; a single point is a curve of one
};

struct PlotPanel {
  std::string title;
  std::vector<PlotSeries> series{};
  std::vector<std::string> labels{};  ///< enumerators for the values 0, 1, ...; empty: the values are numbers
};

struct Plot {
  std::string title;
  std::string subtitle{};
  double from = 0;  ///< begin of the time axis, in s
  double to = 0;    ///< end of the time axis, in s
  std::vector<PlotPanel> panels{};
};

/// The width of the curves in pixels. More than four points per pixel would not be visible.
inline constexpr std::size_t kPlotColumns = 900;

std::string plot_svg(const Plot& plot);

/// Marks for an axis between `from` and `to`, spaced by 1, 2 or 5 times a power of ten. Returns about `about`
/// marks, at least one.
std::vector<double> ticks(double from, double to, std::size_t about);

/// The best unit for a duration: "us", "ms", "s", "min" or "h", and its length in seconds.
struct TimeUnit {
  const char* name;
  double seconds;
};
TimeUnit unit_of_time(double seconds);

}  // namespace takt::tool
