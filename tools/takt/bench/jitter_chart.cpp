#include "jitter_chart.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include <fmt/format.h>

#include "distribution.hpp"
#include "drawing/canvas.hpp"

namespace takt::bench {

const char* const kChartColours = R"(
.spread { fill: #9cc0ea; stroke: #9cc0ea; stroke-width: 1; }
.median { fill: none; stroke: #1d5fa8; stroke-width: 1.5; }
.alone { fill: #1d5fa8; }
.bar { fill: #6fa3dc; }
.bare { fill: none; stroke: #b3541e; stroke-width: 1.5; }
)";
const char* const kDarkChartColours = R"(
.spread { fill: #2f5580; stroke: #2f5580; }
.median { stroke: #7db4f0; }
.alone { fill: #7db4f0; }
.bar { fill: #3f72a8; }
.bare { stroke: #f0b060; }
)";

namespace {

using tool::Canvas;
using tool::kNormal;
using tool::kSmall;
using tool::Point;

constexpr double kLeft = 80;
constexpr double kTop = 30;
constexpr double kWidth = 860;
constexpr double kHeight = 180;
constexpr std::size_t kColumns = 430;

std::int64_t size_of(std::int64_t value) { return value < 0 ? -value : value; }

/// The position of a value on the logarithmic scale, in decades above kLeastSize. Smaller values are drawn on
/// the axis.
double decades(double size) { return std::log10(std::max(size, kLeastSize) / kLeastSize); }

/// The number of decades that a scale up to this value needs. Every scale reaches at least 10 us, so that
/// charts can be compared.
int scale_for(double largest) { return std::max(3, static_cast<int>(std::ceil(decades(largest)))); }

std::string size_text(int decade) {
  const double ns = kLeastSize * std::pow(10, decade);
  return ns < 1e3   ? fmt::format("{:g} ns", ns)
         : ns < 1e6 ? fmt::format("{:g} us", ns / 1e3)
                    : fmt::format("{:g} ms", ns / 1e6);
}

void begin(Canvas& canvas, const std::string& title) {
  canvas.text(kLeft, kTop - 12, kNormal, "title", title);
  canvas.rectangle(kLeft, kTop, kWidth, kHeight, "panel");
}

struct Sample {
  const char* look;
  bool area;  // show a filled area, not a line
  const char* text;
};

/// Draws the legend above the chart, to the right of the title.
void legend(Canvas& canvas, std::initializer_list<Sample> samples) {
  double x = kLeft + kWidth;
  for (const Sample& sample : samples) x -= tool::width_of(sample.text, kSmall) + 24 + 14;
  for (const Sample& sample : samples) {
    x += 14;
    const double y = kTop - 16;
    if (sample.area)
      canvas.rectangle(x, y - 4, 18, 8, sample.look);
    else
      canvas.path({{x, y}, {x + 18, y}}, sample.look);
    canvas.text(x + 24, kTop - 12, kSmall, "faint", sample.text);
    x += 24 + tool::width_of(sample.text, kSmall);
  }
}

void axis_title(Canvas& canvas, const char* text) {
  canvas.centred(kLeft + kWidth / 2, kTop + kHeight + 32, kSmall, "faint", text);
}

}  // namespace

std::string jitter_over_time(const std::string& title, const std::vector<Served>& served,
                             Nanoseconds period) {
  Canvas canvas;
  begin(canvas, title);
  std::int64_t largest = 0;
  for (const Served& one : served) largest = std::max(largest, size_of(one.value));
  const int scale = scale_for(static_cast<double>(largest));
  const auto y_of = [scale](std::int64_t size) {
    return kTop + kHeight * (1 - decades(static_cast<double>(size)) / scale);
  };
  for (int decade = 0; decade <= scale; ++decade) {
    const double y = kTop + kHeight * (1 - static_cast<double>(decade) / scale);
    canvas.line(kLeft, y, kLeft + kWidth, y, "lane");
    canvas.text_before(kLeft - 6, y + 4, kSmall, "faint", size_text(decade));
  }
  if (served.empty()) {
    canvas.text(kLeft + 10, kTop + kHeight / 2, kNormal, "faint", "no release was recorded");
    return canvas.figure(title);
  }

  legend(canvas, {{"spread", true, "minimum to maximum"}, {"median", false, "median"}});
  const std::int64_t first = served.front().number;
  const auto span = static_cast<double>(served.back().number - first + 1);
  const double seconds = span * std::chrono::duration<double>(period).count();
  // In a short measurement, each release has its own column, so that the line joins neighbouring releases.
  const double columns = std::min(static_cast<double>(kColumns), span);
  const auto column_of = [first, span, columns](const Served& one) {
    return static_cast<std::size_t>(static_cast<double>(one.number - first) / span * columns);
  };
  std::vector<Point> upper;
  std::vector<Point> lower;
  std::vector<Point> median;
  const auto draw = [&] {
    upper.insert(upper.end(), lower.rbegin(), lower.rend());
    if (median.size() == 1) {
      canvas.line(upper[0].x, upper[0].y, upper[1].x, upper[1].y, "spread");
      canvas.circle(median[0].x, median[0].y, 1.5, "alone");
    } else {
      canvas.path(upper, "spread", true);
      canvas.path(median, "median");
    }
    upper.clear();
    lower.clear();
    median.clear();
  };
  std::size_t last = 0;
  for (std::size_t begin = 0; begin < served.size();) {
    const std::size_t column = column_of(served[begin]);
    if (column > last + 1 && !upper.empty())
      draw();  // end the line here, because the columns between `last` and this one have no releases
    last = column;
    std::vector<std::int64_t> sizes;
    for (; begin < served.size() && column_of(served[begin]) == column; ++begin)
      sizes.push_back(size_of(served[begin].value));
    std::sort(sizes.begin(), sizes.end());
    const double x = kLeft + kWidth * (static_cast<double>(column) + 0.5) / columns;
    upper.push_back({x, y_of(sizes.back())});
    lower.push_back({x, y_of(sizes.front())});
    median.push_back({x, y_of(percentile(sizes, 0.5))});
  }
  draw();
  for (int tenth = 0; tenth <= 10; tenth += 2) {
    const double x = kLeft + kWidth * tenth / 10;
    canvas.line(x, kTop + kHeight, x, kTop + kHeight + 4, "grid");
    canvas.centred(x, kTop + kHeight + 16, kSmall, "faint", fmt::format("{:.3g} s", seconds * tenth / 10));
  }
  axis_title(canvas, "time");
  return canvas.figure(title);
}

std::vector<std::size_t> classes_of(const std::vector<std::int64_t>& values) {
  std::vector<std::size_t> classes(1);
  for (const std::int64_t value : values) {
    const auto size = static_cast<double>(size_of(value));
    const std::size_t place =
        size < kLeastSize ? 0 : 1 + static_cast<std::size_t>(decades(size) * kClassesOfADecade + 1e-9);
    if (place >= classes.size()) classes.resize(place + 1);
    ++classes[place];
  }
  return classes;
}

std::string jitter_histogram(const std::string& title, const std::vector<Served>& served,
                             const std::vector<std::int64_t>& bare) {
  Canvas canvas;
  begin(canvas, title);
  std::vector<std::int64_t> values;
  for (const Served& one : served) values.push_back(one.value);
  const std::vector<std::size_t> ours = classes_of(values);
  const std::vector<std::size_t> theirs = classes_of(bare);
  const std::size_t most = std::max(ours.size(), theirs.size());
  const int scale = std::max(3, static_cast<int>((most + kClassesOfADecade - 2) / kClassesOfADecade));
  const double width = kWidth / (scale * kClassesOfADecade + 1);

  // The vertical axis ranges from the share of one release to the share of all releases (1).
  const double all = static_cast<double>(std::max<std::size_t>({values.size(), bare.size(), 10}));
  const double shares = std::ceil(std::log10(all));
  const auto y_of = [shares](std::size_t count, std::size_t of) {
    const double share = static_cast<double>(count) / static_cast<double>(of);
    return kTop + kHeight * std::min(1.0, -std::log10(share) / shares);
  };
  for (int decade = 0; decade <= static_cast<int>(shares); ++decade) {
    const double y = kTop + kHeight * decade / shares;
    canvas.line(kLeft, y, kLeft + kWidth, y, "lane");
    canvas.text_before(kLeft - 6, y + 4, kSmall, "faint", fmt::format("{:g} %", 100 / std::pow(10, decade)));
  }
  for (std::size_t i = 0; i < ours.size(); ++i) {
    if (ours[i] == 0) continue;
    const double y = y_of(ours[i], values.size());
    canvas.rectangle(kLeft + static_cast<double>(i) * width, y, width - 1, kTop + kHeight - y, "bar");
  }
  std::vector<Point> line;
  for (std::size_t i = 0; i < theirs.size() && !bare.empty(); ++i) {
    const double y = theirs[i] == 0 ? kTop + kHeight : y_of(theirs[i], bare.size());
    line.push_back({kLeft + static_cast<double>(i) * width, y});
    line.push_back({kLeft + static_cast<double>(i + 1) * width, y});
  }
  if (!line.empty()) canvas.path(line, "bare");
  for (int decade = 0; decade <= scale; ++decade) {
    const double x = kLeft + (decade * kClassesOfADecade + 1) * width;
    canvas.line(x, kTop + kHeight, x, kTop + kHeight + 4, "grid");
    canvas.centred(x, kTop + kHeight + 16, kSmall, "faint", size_text(decade));
  }
  if (bare.empty())
    legend(canvas, {{"bar", true, "takt"}});
  else
    legend(canvas, {{"bar", true, "takt"}, {"bare", false, "the bare loop"}});
  axis_title(canvas, "absolute jitter");
  return canvas.figure(title);
}

}  // namespace takt::bench
