// The list of devices and modules in `takt watch`: its rows, their order, and its columns.
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
  const Module* module = nullptr;  ///< null if this row shows the device itself
  bool alone = false;              ///< the row is not below the row of its device, so it names the device too

  [[nodiscard]] std::string target() const;
};

/// The rows that match the filter. If the view sorts by name, each device is followed by its modules. If the
/// view sorts by another column, the rows are only modules, and devices without known modules. The filter
/// searches the name, the state and the reason. A module's name includes the name of its device.
std::vector<Row> rows_of(const Snapshot& snapshot, const View& view);

/// The heading of the list, with a mark at the column by which the rows are sorted.
Line list_heading(const View& view, std::size_t columns, ScreenStyle style);
Line list_line(const Row& row, bool chosen, std::size_t columns, ScreenStyle style);

/// True if `text` contains every word of `filter`; case does not matter.
bool matches(const std::string& text, const std::string& filter);

/// A symbol and a word for a state, so that a user can read the state without colours.
struct State {
  std::string text;  ///< for example "● EXECUTING"
  Ink ink = Ink::plain;
};
/// How well a device or a module is, by the judgement that all commands share.
wire::Rating rating_of(const Device& device);
wire::Rating rating_of(const Device& device, const Module& module);
State state_of(const Device& device, ScreenStyle style);
State state_of(const Device& device, const Module& module, ScreenStyle style);
State state_of(const Connection& connection, ScreenStyle style);

}  // namespace takt::tool::watch
