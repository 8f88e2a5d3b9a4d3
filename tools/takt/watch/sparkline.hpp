// Values over time and shares of a whole, drawn with the characters that a terminal has.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "terminal/screen_style.hpp"

namespace takt::tool::watch {

/// The newest `columns` values, one a column, the newest last; NaN leaves a gap. Heights are those of a
/// jitter in microseconds, the same for all sparklines, so that one can be held against another: each step is
/// three times the one before, from below 1 us to 1 ms and above.
std::string sparkline(const std::vector<double>& values_us, std::size_t columns, ScreenStyle style);

/// The same as a picture of `lines` lines, from 0 to the largest value.
std::vector<std::string> chart(const std::vector<double>& values, std::size_t columns, std::size_t lines,
                               ScreenStyle style);

/// A share, 1 for the whole, as a bar of `columns`; what is more than the whole fills it.
std::string bar(double share, std::size_t columns, ScreenStyle style);

}  // namespace takt::tool::watch
