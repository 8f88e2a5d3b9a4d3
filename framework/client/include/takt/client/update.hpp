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
  /// Called with one line for the user, which says what update() is doing.
  std::function<void(const std::string&)> progress;
  /// Called with the differences, one per line, before anything is changed. Not called if there are none.
  std::function<void(const std::vector<std::string>&)> differs;
  /// Called repeatedly until update() is done. If it returns true, update() undoes all changes.
  std::function<bool()> cancelled;
};

struct Updated {
  Problems problems{};  ///< why the cell was not updated; empty if it now matches the new descriptor
  std::string outcome;  ///< a sentence about the present state of the cell
};

/// Asks each device what differs and whether it can make the change. Then all devices make their changes in
/// parallel, and then make them permanent. If a device cannot make its change, all devices undo theirs.
/// `text` is the descriptor that `cell` was read from. If no cell with this name runs, reports a problem.
Updated update(Operator& asker, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options);

}  // namespace takt::client
