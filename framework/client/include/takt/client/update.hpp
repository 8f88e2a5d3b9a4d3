// Updates a running cell to another descriptor: on all of its devices or on none. Only differences are
// changed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct UpdateOptions {
  /// Called with one line for a person: what update() waits for.
  std::function<void(const std::string&)> progress;
  /// Called with the differences, one a line, before any is carried out; not called if there are none.
  std::function<void(const std::vector<std::string>&)> differs;
  /// Polled until all is done; when it returns true, all changes are undone.
  std::function<bool()> cancelled;
};

struct Updated {
  Problems problems{};  ///< why the cell was not updated; empty: it now matches the descriptor
  std::string outcome;  ///< the state of the cell now, in one sentence
};

/// Asks each device what differs and whether it can change it. Then all devices make their changes at the
/// same time, and then all confirm them. If one device fails, the others undo their changes. `text` is the
/// descriptor that `cell` was read from. If no cell of that name runs, that is one of the problems.
Updated update(Operator& asker, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options);

}  // namespace takt::client
