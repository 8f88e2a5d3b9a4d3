// Draws the screen of `takt watch`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "terminal/screen_style.hpp"
#include "watch/seen.hpp"
#include "watch/view.hpp"

namespace takt::tool::watch {

struct Screen {
  std::vector<std::string> lines;  ///< one for each line of the terminal, none wider than the terminal
  Shown shown;
};

/// Draws a snapshot. First adapts `view` to the snapshot, so that the selected row is visible and no page is
/// scrolled past its end. The screen names states in words; `style` may add colour.
Screen draw(const Snapshot& snapshot, View& view, std::size_t columns, std::size_t lines, ScreenStyle style);

/// Returns the text that changes a terminal from showing `before` to showing `now`. If the number of lines
/// differs, the text redraws the whole screen.
std::string changes(const std::vector<std::string>& before, const std::vector<std::string>& now);

}  // namespace takt::tool::watch
