// Draws values over time, and shares of a whole, with text characters.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "terminal/screen_style.hpp"

namespace takt::tool::watch {

/// Draws the newest `columns` values, one per column, newest last. NaN leaves a gap. Values are jitter in
/// microseconds. All sparklines use the same scale, so that they can be compared: each step is about three
/// times the one before, from below 1 us to 1 ms and above.
std::string sparkline(const std::vector<double>& values_us, std::size_t columns, ScreenStyle style);

/// Draws the same values as a bar chart of `lines` lines, scaled from 0 to the largest value.
std::vector<std::string> chart(const std::vector<double>& values, std::size_t columns, std::size_t lines,
                               ScreenStyle style);

/// Draws a share (1 is the whole) as a bar of `columns`. A share above 1 fills the bar.
std::string bar(double share, std::size_t columns, ScreenStyle style);

}  // namespace takt::tool::watch
