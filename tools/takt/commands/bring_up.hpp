// Shows on the terminal, during the start of a cell, which devices and modules are ready.
#pragma once

#include <string>

#include <takt/client/connection.hpp>
#include <takt/model/cell.hpp>

#include "terminal/progress.hpp"

namespace takt::tool {

class BringUpProgress {
 public:
  /// `client` and `cell` must outlive this object.
  BringUpProgress(const client::Connection& client, const model::Cell& cell);

  /// Prints a permanent line to standard error, even if standard error is not a terminal.
  void print(const std::string& text);
  /// Redraws the progress line if it is due for an update. Call this function often.
  void refresh() {
    if (progress_.is_due()) show();
  }
  /// Removes the progress line. If the start succeeded, first shows the modules that have become ready since
  /// the last update.
  void end(bool went_well);

 private:
  void show();

  const client::Connection& client_;
  const model::Cell& cell_;
  BringUp bring_up_;
  Progress progress_;
};

}  // namespace takt::tool
