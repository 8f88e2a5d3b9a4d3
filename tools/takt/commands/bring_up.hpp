// How a cell's devices and modules are made ready, told to whoever sits at the terminal while it happens.
#pragma once

#include <string>

#include <takt/client/connection.hpp>
#include <takt/model/cell.hpp>

#include "terminal/progress.hpp"

namespace takt::tool {

class BringUpProgress {
 public:
  /// Both outlive it.
  BringUpProgress(const client::Connection& client, const model::Cell& cell);

  /// A line that is said whether it is a terminal or not.
  void say(const std::string& text);
  /// To be called all the time.
  void look() {
    if (progress_.is_due()) show();
  }
  /// What follows is said by others. Where it went well, with what has not been told yet.
  void end(bool went_well);

 private:
  void show();

  const client::Connection& client_;
  const model::Cell& cell_;
  BringUp bring_up_;
  Progress progress_;
};

}  // namespace takt::tool
