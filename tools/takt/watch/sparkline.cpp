#include "watch/sparkline.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace takt::tool::watch {

namespace {

constexpr std::array kBlocks{"▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
constexpr std::array kMarks{"_", ".", ",", "-", "=", "+", "*", "#"};
constexpr std::size_t kLevels = kBlocks.size();
/// A value's level rises by one at each step. Values below the first step have the lowest level.
constexpr std::array kSteps_us{1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0};
static_assert(kSteps_us.size() + 1 == kLevels);

const char* level(std::size_t of, ScreenStyle style) {
  return style.unicode ? kBlocks.at(of) : kMarks.at(of);
}

/// The newest `columns` values. If there are fewer, gaps (NaN) come first.
std::vector<double> newest(const std::vector<double>& values, std::size_t columns) {
  std::vector<double> shown(columns, std::nan(""));
  const std::size_t taken = std::min(columns, values.size());
  std::copy_n(values.end() - static_cast<std::ptrdiff_t>(taken), taken,
              shown.end() - static_cast<std::ptrdiff_t>(taken));
  return shown;
}

}  // namespace

std::string sparkline(const std::vector<double>& values_us, std::size_t columns, ScreenStyle style) {
  std::string line;
  for (const double value : newest(values_us, columns)) {
    const auto above =
        std::count_if(kSteps_us.begin(), kSteps_us.end(), [value](double s) { return value >= s; });
    line += std::isnan(value) ? " " : level(static_cast<std::size_t>(above), style);
  }
  return line;
}

std::vector<std::string> chart(const std::vector<double>& values, std::size_t columns, std::size_t lines,
                               ScreenStyle style) {
  const std::vector<double> shown = newest(values, columns);
  double most = 0;
  for (const double value : shown) most = std::isnan(value) ? most : std::max(most, value);
  std::vector<std::string> rows(lines);
  for (const double value : shown) {
    if (std::isnan(value)) {
      for (std::string& line : rows) line += " ";
      continue;
    }
    // Even a value of 0 gets a bar of one step, so that it differs from a gap.
    const double steps = static_cast<double>(lines * kLevels);
    const double height = most > 0 ? std::max(value / most * steps, 1.0) : 1.0;
    for (std::size_t i = 0; i < lines; ++i) {
      const double above = height - static_cast<double>((lines - 1 - i) * kLevels);
      const auto filled = static_cast<std::size_t>(std::clamp(std::round(above), 0.0, double{kLevels}));
      rows[i] += filled == 0 ? " " : level(filled - 1, style);
    }
  }
  return rows;
}

std::string bar(double share, std::size_t columns, ScreenStyle style) {
  constexpr std::array kEighths{"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const double filled = std::clamp(share, 0.0, 1.0) * static_cast<double>(columns);
  const auto eighths = static_cast<std::size_t>(filled * 8);
  const std::size_t whole = eighths / 8;
  const std::size_t rest = eighths % 8;
  std::string text;
  for (std::size_t i = 0; i < whole; ++i) text += style.unicode ? "█" : "#";
  if (style.unicode) text += kEighths.at(rest);
  std::size_t taken = whole + (style.unicode && rest > 0 ? 1 : 0);
  for (; taken < columns; ++taken) text += style.unicode ? "·" : ".";
  return text;
}

}  // namespace takt::tool::watch
