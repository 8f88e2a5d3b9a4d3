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
  std::vector<std::string> lines;  ///< as many as the terminal has, none wider than the terminal
  Shown shown;
};

/// Draws a snapshot. Adapts `view` to the snapshot: the selected row is visible, and no page is scrolled past
/// its end. States are shown as words; `style` may add colour.
Screen draw(const Snapshot& snapshot, View& view, std::size_t columns, std::size_t lines, ScreenStyle style);

/// The text to send to a terminal that shows `before`, so that it shows `now`. If the number of lines
/// differs, the text draws the whole screen.
std::string changes(const std::vector<std::string>& before, const std::vector<std::string>& now);

}  // namespace takt::tool::watch
