// The whole screen of `takt watch`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "terminal/screen_style.hpp"
#include "watch/seen.hpp"
#include "watch/view.hpp"

namespace takt::tool::watch {

struct Screen {
  std::vector<std::string> lines;  ///< as many as the terminal has, none wider than it is
  Shown shown;
};

/// `view` is settled on what there is: its row is among those that are shown, and nothing is scrolled past
/// its end. States are words; colour comes on top where `style` has it.
Screen draw(const Seen& seen, View& view, std::size_t columns, std::size_t lines, ScreenStyle style);

/// What a terminal that shows `before` is sent so that it shows `now`; all of it where the number of lines
/// differs.
std::string changes(const std::vector<std::string>& before, const std::vector<std::string>& now);

}  // namespace takt::tool::watch
