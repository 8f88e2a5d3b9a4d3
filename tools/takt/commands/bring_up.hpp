// Shows on the terminal how the devices and modules of a cell become ready, while it happens.
#pragma once

#include <string>

#include <takt/client/connection.hpp>
#include <takt/model/cell.hpp>

#include "terminal/progress.hpp"

namespace takt::tool {

class BringUpProgress {
 public:
  /// `client` and `cell` outlive this object.
  BringUpProgress(const client::Connection& client, const model::Cell& cell);

  /// Prints a line, whether standard error is a terminal or not.
  void print(const std::string& text);
  /// Redraws the progress if it is due. Call it often.
  void refresh() {
    if (progress_.is_due()) show();
  }
  /// Removes the progress from the screen. If the start succeeded, shows the remaining modules first.
  void end(bool went_well);

 private:
  void show();

  const client::Connection& client_;
  const model::Cell& cell_;
  BringUp bring_up_;
  Progress progress_;
};

}  // namespace takt::tool
