// Draws curves as SVG, with a panel for each field. All panels have the same time axis.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace takt::tool {

struct PlotPoint {
  double time = 0;  ///< seconds since the beginning of the recording
  double value = 0;
};

struct PlotSeries {
  std::string name;
  std::vector<std::vector<PlotPoint>>
      curves{};  ///< each curve is drawn as one line; a curve may have only one point
};

struct PlotPanel {
  std::string title;
  std::vector<PlotSeries> series{};
  std::vector<std::string>
      labels{};  ///< the enumerators for the values 0, 1, ...; empty if the values are numbers
};

struct Plot {
  std::string title;
  std::string subtitle{};
  double from = 0;  ///< beginning of the time axis, in seconds
  double to = 0;    ///< end of the time axis, in seconds
  std::vector<PlotPanel> panels{};
};

/// The width of a panel in pixels. A curve needs no more than four points per pixel.
inline constexpr std::size_t kPlotColumns = 900;

std::string plot_svg(const Plot& plot);

/// Chooses the marks of an axis between `from` and `to`. The distance of two marks is 1, 2 or 5 times a power
/// of ten. Returns about `about` marks, but at least one.
std::vector<double> ticks(double from, double to, std::size_t about);

/// A unit for durations: "us", "ms", "s", "min" or "h", and its length in seconds. unit_of_time() chooses the
/// unit for a duration.
struct TimeUnit {
  const char* name;
  double seconds;
};
TimeUnit unit_of_time(double seconds);

}  // namespace takt::tool
