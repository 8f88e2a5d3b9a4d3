// Curves as a picture: a panel for each field, one axis of time for all.
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
  std::vector<std::vector<PlotPoint>> curves{};  ///< what is connected; a lone point is a curve of one
};

struct PlotPanel {
  std::string title;
  std::vector<PlotSeries> series{};
  std::vector<std::string> labels{};  ///< of the values 0, 1, ...: an enumeration; empty: numbers
};

struct Plot {
  std::string title;
  std::string subtitle{};
  double from = 0;  ///< s, what the axis of time shows
  double to = 0;
  std::vector<PlotPanel> panels{};
};

/// How wide the curves are drawn, in pixels: more points than four for each would not be seen.
inline constexpr std::size_t kPlotColumns = 900;

std::string plot_svg(const Plot& plot);

/// Marks of an axis: 1, 2 or 5 times a power of ten apart, all within from and to, about so many. At least
/// one.
std::vector<double> ticks(double from, double to, std::size_t about);

/// The unit in which so many seconds are read best: "us", "ms", "s", "min" or "h", and how many s it has.
struct TimeUnit {
  const char* name;
  double seconds;
};
TimeUnit unit_of_time(double seconds);

}  // namespace takt::tool
