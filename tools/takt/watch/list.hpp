// The list of devices and modules: which rows, in which order, in which columns.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "watch/line.hpp"
#include "watch/seen.hpp"
#include "watch/view.hpp"

namespace takt::tool::watch {

struct Row {
  const Device* device = nullptr;
  const Module* module = nullptr;  ///< null: the row of the device
  bool alone = false;              ///< not below its device, so it names it

  [[nodiscard]] std::string target() const;
};

/// By name each device and its modules below it; by anything else the modules of all devices, and those
/// devices of which no module is known. The filter's words are looked for in name, state and reason; what a
/// device has in its name its modules have too.
std::vector<Row> rows_of(const Seen& seen, const View& view);

/// The heading, with a sign at the column by which the rows are sorted.
Line list_heading(const View& view, std::size_t columns, ScreenStyle style);
Line list_line(const Row& row, bool chosen, std::size_t columns, ScreenStyle style);

/// Whether all words of `filter` are in `text`, upper and lower case alike.
bool matches(const std::string& text, const std::string& filter);

/// A sign and a word, the first for those who cannot see the colour at a glance.
struct State {
  std::string text;  ///< "● EXECUTING"
  Ink ink = Ink::plain;
};
State state_of(const Device& device, ScreenStyle style);
State state_of(const Device& device, const Module& module, ScreenStyle style);
State state_of(const Connection& connection, ScreenStyle style);

}  // namespace takt::tool::watch
