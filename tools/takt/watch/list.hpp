// The list of devices and modules in `takt watch`: its rows, their order, and the columns.
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
  bool alone = false;              ///< not listed below its device, so the row also names the device

  [[nodiscard]] std::string target() const;
};

/// The rows that match the filter. If the view sorts by name, each device is followed by its modules. If the
/// view sorts by another column, the rows are only modules, and devices without known modules. The filter
/// searches name, state and reason; the name of a module includes that of its device.
std::vector<Row> rows_of(const Snapshot& snapshot, const View& view);

/// The heading, with a mark at the column by which the rows are sorted.
Line list_heading(const View& view, std::size_t columns, ScreenStyle style);
Line list_line(const Row& row, bool chosen, std::size_t columns, ScreenStyle style);

/// Whether `text` contains all words of `filter`, ignoring case.
bool matches(const std::string& text, const std::string& filter);

/// A symbol and a word for a state, so that a user can read the state without colours.
struct State {
  std::string text;  ///< "● EXECUTING"
  Ink ink = Ink::plain;
};
State state_of(const Device& device, ScreenStyle style);
State state_of(const Device& device, const Module& module, ScreenStyle style);
State state_of(const Connection& connection, ScreenStyle style);

}  // namespace takt::tool::watch
