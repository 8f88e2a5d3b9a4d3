// Draws small charts from text characters: values over time, and a share of a whole.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "terminal/screen_style.hpp"

namespace takt::tool::watch {

/// Draws the newest `columns` jitter values, in microseconds, one per column, newest last. NaN leaves a gap.
/// All sparklines use the same scale, so that users can compare them: the levels start at 0, 1, 3, 10, 30,
/// 100, 300 and 1000 us.
std::string sparkline(const std::vector<double>& values_us, std::size_t columns, ScreenStyle style);

/// Draws the newest `columns` values as a bar chart that is `lines` lines high, scaled from 0 to the largest
/// value.
std::vector<std::string> chart(const std::vector<double>& values, std::size_t columns, std::size_t lines,
                               ScreenStyle style);

/// Draws a share as a bar that is `columns` wide. A share of 1 or more fills the bar.
std::string bar(double share, std::size_t columns, ScreenStyle style);

}  // namespace takt::tool::watch
