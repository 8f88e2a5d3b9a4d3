// A cell that runs becomes what another descriptor says: on all of its devices or on none, and only where it
// differs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct UpdateOptions {
  /// One line for a person: what is being waited for.
  std::function<void(const std::string&)> progress;
  /// What differs, a line each, before any of it is changed; not called when nothing does.
  std::function<void(const std::vector<std::string>&)> differs;
  /// Whether it is to be given up; all is put back then. Asked all the time.
  std::function<bool()> cancelled;
};

struct Updated {
  Problems problems{};  ///< why it was not updated; empty: it is as the descriptor says
  std::string outcome;  ///< how the cell stands now, in one sentence
};

/// Asks each device what differs and whether it can be changed, then has all change it at once, then has all
/// keep it. Where one does not, those that did put it back. `text` is the descriptor that `cell` was read
/// from. The cell of that name runs; where it does not, that is one of the problems.
Updated update(Operator& asker, const model::Cell& cell, const std::string& text,
               const UpdateOptions& options);

}  // namespace takt::client
