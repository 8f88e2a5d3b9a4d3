// Which processors a device's threads run on.
#pragma once

#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::node {

struct Placement {
  std::vector<std::vector<int>> executors;  ///< of each executor; empty: any
  std::vector<int> background;        ///< of process modules, hooks and non-real-time modules; never empty
  std::vector<std::string> warnings;  ///< wishes that this machine cannot fulfil
};

/// Executors get the processor that the descriptor names, or one each from the highest down; everything else
/// gets those that are left, or all where none is left. Pure.
Placement place(const std::vector<model::Executor>& executors, const std::vector<int>& allowed);

}  // namespace takt::node
