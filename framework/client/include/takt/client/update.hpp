// Updates a running cell to another descriptor, on all of its devices or on none. Modules that do not differ
// are not changed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct UpdateOptions {
  /// update() calls this function with a line of text that tells the user what update() is doing.
  std::function<void(const std::string&)> progress;
  /// Before update() changes anything, it calls this function with the differences, one per string. Not
  /// called if there are no differences.
  std::function<void(const std::vector<std::string>&)> differs;
  /// update() calls this function repeatedly. If it returns true, update() undoes all changes.
  std::function<bool()> cancelled;
};

struct Updated {
  Problems problems{};  ///< the reasons why the cell was not updated; empty if the cell now matches the new
                        ///< descriptor
  std::string outcome;  ///< a sentence about the present state of the cell
  Problems failed_modules{};  ///< modules that have failed although the cell matches the descriptor
};

/// Updates a running cell. Each device first reports the differences, and whether it can make the changes.
/// Then all devices make their changes in parallel, and decide together to keep them. If a device cannot make
/// its changes, all devices undo their changes. `text` is the descriptor from which `cell` was
/// read. If no cell with this name runs, reports a problem.
Updated update(Operator& sender, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options);

}  // namespace takt::client
