#include "reports/plot_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "drawing/canvas.hpp"

namespace takt::tool {

namespace {

// Sizes are in pixels.
constexpr double kPanel = 200;
constexpr double kGap = 34;  // space between panels, for a title and the first line of the legend
constexpr double kPlotWide = static_cast<double>(kPlotColumns);
constexpr std::size_t kCurveColours = 8;  // number of colours; the ninth curve has the first colour again
constexpr std::size_t kShapes = 5;        // number of shapes; 40 curves differ in colour or shape
constexpr double kApart = 90;             // distance of two shapes on a curve

constexpr std::string_view kColourWords = R"(.axis { stroke: #8a96a3; stroke-width: 1; }
.curve { fill: none; stroke-width: 1.4; stroke-linejoin: round; }
.c0 { stroke: #1d5fa8; } .d0 { fill: #1d5fa8; }
.c1 { stroke: #c2571a; } .d1 { fill: #c2571a; }
.c2 { stroke: #2f8a57; } .d2 { fill: #2f8a57; }
.c3 { stroke: #a03a78; } .d3 { fill: #a03a78; }
.c4 { stroke: #7a6a00; } .d4 { fill: #7a6a00; }
.c5 { stroke: #0e8a94; } .d5 { fill: #0e8a94; }
.c6 { stroke: #6b4fc0; } .d6 { fill: #6b4fc0; }
.c7 { stroke: #5c6773; } .d7 { fill: #5c6773; }
)";

constexpr std::string_view kDarkColourWords = R"(.axis { stroke: #6b7784; }
.c0 { stroke: #7db4f0; } .d0 { fill: #7db4f0; }
.c1 { stroke: #f0935a; } .d1 { fill: #f0935a; }
.c2 { stroke: #6ccf95; } .d2 { fill: #6ccf95; }
.c3 { stroke: #e58cc4; } .d3 { fill: #e58cc4; }
.c4 { stroke: #d6c445; } .d4 { fill: #d6c445; }
.c5 { stroke: #52ccd6; } .d5 { fill: #52ccd6; }
.c6 { stroke: #b5a1f2; } .d6 { fill: #b5a1f2; }
.c7 { stroke: #a9b4bf; } .d7 { fill: #a9b4bf; }
)";

struct Extent {
  double low = 0;
  double high = 1;
};

/// The range of a panel's value axis, which is a little wider than the range of the values.
Extent extent_of(const PlotPanel& panel) {
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const PlotSeries& series : panel.series) {
    for (const auto& curve : series.curves) {
      for (const PlotPoint& point : curve) {
        low = std::min(low, point.value);
        high = std::max(high, point.value);
      }
    }
  }
  if (!panel.labels.empty()) {
    low = 0;
    high = static_cast<double>(panel.labels.size() - 1);
  }
  if (low > high) return {};
  // Subtract halves, because the difference of two large doubles could overflow.
  const double span = high / 2 - low / 2;
  const double margin = span > 0 ? span * 0.1 : std::max(std::abs(low) * 0.1, 0.5);
  constexpr double kMost = std::numeric_limits<double>::max() *
                           0.99;  // limit of an axis, so that a mark beyond the axis is still finite
  return {std::max(low - margin, -kMost), std::min(high + margin, kMost)};
}

bool is_whole(double value) { return std::abs(value) < 1e15 && value == std::round(value); }

/// True if all values are whole numbers. If so, the axis has no marks between whole numbers.
bool are_whole(const PlotPanel& panel) {
  return std::all_of(panel.series.begin(), panel.series.end(), [](const PlotSeries& series) {
    return std::all_of(series.curves.begin(), series.curves.end(), [](const auto& curve) {
      return std::all_of(curve.begin(), curve.end(),
                         [](const PlotPoint& point) { return is_whole(point.value); });
    });
  });
}

/// The text of a mark, with enough digits to distinguish it from a mark one step away.
std::string mark_text(double value, double step) {
  if (value == 0) return "0";
  const double size = std::abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const double decades = std::floor(std::log10(size)) - std::floor(std::log10(step) + 1e-9);
    return fmt::format("{:.{}g}", value, 1 + static_cast<int>(std::clamp(decades, 0.0, 14.0)));
  }
  const int digits = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return fmt::format("{:.{}f}", value, digits);
}

class PlotDrawing {
 public:
  explicit PlotDrawing(const Plot& plot)
      : plot_(plot), unit_(unit_of_time(plot.to > plot.from ? plot.to - plot.from : plot.to)) {}

  std::string svg() {
    double y = kMargin + 14;
    canvas_.text(kMargin, y, kLarge + 4, "title", plot_.title);
    y += 20;
    canvas_.text(kMargin, y, kNormal, "faint", plot_.subtitle);
    left_ = kMargin + label_width() + 10;
    y += 14;
    for (const PlotPanel& panel : plot_.panels) y = draw(panel, y);
    time_axis(y);
    return canvas_.document(plot_.title, kColourWords, kDarkColourWords);
  }

 private:
  struct Mark {
    double value;
    std::string text;
  };
  [[nodiscard]] static std::vector<Mark> marks(const PlotPanel& panel) {
    std::vector<Mark> marks;
    const Extent extent = extent_of(panel);
    if (!panel.labels.empty()) {
      const std::size_t every = panel.labels.size() / 12 + 1;
      for (std::size_t i = 0; i < panel.labels.size(); i += every)
        marks.push_back({static_cast<double>(i), panel.labels[i]});
      return marks;
    }
    std::vector<double> values = ticks(extent.low, extent.high, 5);
    double step = values.size() > 1 ? values[1] - values[0] : 1;
    if (step < 1 && are_whole(panel)) {
      values.clear();
      for (double value = std::ceil(extent.low); value <= extent.high; ++value) values.push_back(value);
      step = 1;
    }
    for (const double value : values) marks.push_back({value, mark_text(value, step)});
    return marks;
  }
  [[nodiscard]] double label_width() const {
    double widest = 0;
    for (const PlotPanel& panel : plot_.panels) {
      for (const Mark& mark : marks(panel)) widest = std::max(widest, width_of(mark.text, kSmall));
    }
    return widest;
  }
  [[nodiscard]] double x_of(double time) const {
    const double length = plot_.to - plot_.from;
    return left_ + kPlotWide * (length > 0 ? std::clamp((time - plot_.from) / length, 0.0, 1.0) : 0.5);
  }

  /// Draws a panel, and returns the y coordinate at which the next panel may begin.
  double draw(const PlotPanel& panel, double y) {
    y += 16;
    canvas_.text(kMargin, y, kNormal, "title", panel.title);
    y = legend(panel, y + 4) + 10;
    const Extent extent = extent_of(panel);
    const auto y_of = [&](double value) {
      const double share = (value / 2 - extent.low / 2) / (extent.high / 2 - extent.low / 2);
      return y + kPanel * (1 - std::clamp(share, 0.0, 1.0));
    };
    canvas_.rectangle(left_, y, kPlotWide, kPanel, "panel");
    for (const Mark& mark : marks(panel)) {
      canvas_.line(left_, y_of(mark.value), left_ + kPlotWide, y_of(mark.value), "lane");
      canvas_.text_before(left_ - 6, y_of(mark.value) + 3.5, kSmall, "faint", mark.text);
    }
    for (const double mark : time_marks()) canvas_.line(x_of(mark), y, x_of(mark), y + kPanel, "lane");
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      canvas_.open_group(panel.series[i].name);
      // Shift the shapes of each curve along the curve, so that they stay visible when curves overlap.
      double next =
          left_ + kApart * (static_cast<double>(i) + 0.5) / static_cast<double>(panel.series.size());
      for (const auto& curve : panel.series[i].curves) {
        if (curve.size() == 1 && panel.series.size() > 1) {
          shape(i, {x_of(curve[0].time), y_of(curve[0].value)});
          continue;
        }
        if (curve.size() == 1) {
          canvas_.circle(x_of(curve[0].time), y_of(curve[0].value), 2, fmt::format("d{}", i % kCurveColours));
          continue;
        }
        std::vector<Point> points;
        points.reserve(curve.size());
        for (const PlotPoint& point : curve) {
          // An enumerator is valid until the next sample, so draw steps.
          if (!panel.labels.empty() && !points.empty()) points.push_back({x_of(point.time), points.back().y});
          points.push_back({x_of(point.time), y_of(point.value)});
        }
        canvas_.path(points, fmt::format("curve c{}", i % kCurveColours));
        if (panel.series.size() > 1) next = shapes(i, points, next);
      }
      canvas_.close_group();
    }
    canvas_.line(left_, y, left_, y + kPanel, "axis");
    canvas_.line(left_, y + kPanel, left_ + kPlotWide, y + kPanel, "axis");
    return y + kPanel + kGap - 20;
  }

  /// Draws the shape that marks a curve, for readers who cannot distinguish the colours.
  void shape(std::size_t series, Point at) {
    const std::string look = fmt::format("d{}", series % kCurveColours);
    constexpr double r = 3.5;
    switch (series % kShapes) {
      case 0:
        return canvas_.circle(at.x, at.y, r - 0.5, look);
      case 1:
        return canvas_.rectangle(at.x - r + 0.5, at.y - r + 0.5, 2 * r - 1, 2 * r - 1, look);
      case 2:
        return canvas_.path({{at.x - r, at.y + r}, {at.x, at.y - r}, {at.x + r, at.y + r}}, look, true);
      case 3:
        return canvas_.path({{at.x - r, at.y - r}, {at.x, at.y + r}, {at.x + r, at.y - r}}, look, true);
      default:
        return canvas_.diamond(at.x, at.y, 4, look);
    }
  }

  /// Draws the shapes on a curve, from the x coordinate `next` to the right. Returns the x coordinate of the
  /// next shape.
  double shapes(std::size_t series, const std::vector<Point>& curve, double next) {
    while (next < curve.front().x) next += kApart;
    for (std::size_t i = 1; i < curve.size(); ++i) {
      const Point& a = curve[i - 1];
      const Point& b = curve[i];
      for (; next <= b.x; next += kApart)
        shape(series, {next, b.x > a.x ? a.y + (b.y - a.y) * (next - a.x) / (b.x - a.x) : b.y});
    }
    return next;
  }

  /// Draws the legend of a panel, on as many lines as it needs. Returns the y coordinate of the last line.
  double legend(const PlotPanel& panel, double y) {
    double x = kMargin;
    y += 12;
    for (std::size_t i = 0; i < panel.series.size(); ++i) {
      const double wide = 24 + width_of(panel.series[i].name, kSmall) + 16;
      if (x > kMargin && x + wide > left_ + kPlotWide) {
        x = kMargin;
        y += 15;
      }
      canvas_.rectangle(x, y - 5, 18, 2, fmt::format("d{}", i % kCurveColours));
      if (panel.series.size() > 1) shape(i, {x + 9, y - 4});
      canvas_.text(x + 24, y, kSmall, "faint", panel.series[i].name);
      x += wide;
    }
    return y;
  }

  [[nodiscard]] std::vector<double> time_marks() const {
    std::vector<double> marks = ticks(plot_.from / unit_.seconds, plot_.to / unit_.seconds, 9);
    for (double& mark : marks) mark *= unit_.seconds;
    return marks;
  }
  void time_axis(double y) {
    const std::vector<double> all = time_marks();
    const double step = all.size() > 1 ? (all[1] - all[0]) / unit_.seconds : 1;
    double free = 0;  // the next label fits from this x coordinate on
    for (const double mark : all) {
      const std::string text = mark_text(mark / unit_.seconds, step);
      const double half = width_of(text, kSmall) / 2;
      if (x_of(mark) - half < free) continue;
      canvas_.centred(x_of(mark), y, kSmall, "faint", text);
      free = x_of(mark) + half + 8;
    }
    canvas_.centred(left_ + kPlotWide / 2, y + 18, kSmall, "faint", fmt::format("time in {}", unit_.name));
  }

  const Plot& plot_;
  const TimeUnit unit_;
  Canvas canvas_;
  double left_ = 0;
};

}  // namespace

TimeUnit unit_of_time(double seconds) {
  if (seconds < 1e-3) return {"us", 1e-6};
  if (seconds < 1) return {"ms", 1e-3};
  if (seconds <= 600) return {"s", 1};
  if (seconds <= 5 * 3600.0) return {"min", 60};
  return {"h", 3600};
}

std::vector<double> ticks(double from, double to, std::size_t about) {
  if (!(to > from)) return {from};
  const double rough = (to / static_cast<double>(about) - from / static_cast<double>(about));
  const double power = std::pow(10, std::floor(std::log10(rough)));
  double step = 10 * power;
  for (const double times : {1.0, 2.0, 5.0}) {
    if (times * power >= rough) {
      step = times * power;
      break;
    }
  }
  std::vector<double> marks;
  for (double n = std::ceil(from / step - 1e-9); n * step <= to + step * 1e-9; ++n) {
    marks.push_back(n * step);
    if (marks.size() > 4 * about) break;  // the range is too small for the precision of a double
  }
  if (marks.empty()) marks.push_back(from);
  return marks;
}

std::string plot_svg(const Plot& plot) { return PlotDrawing{plot}.svg(); }

}  // namespace takt::tool
