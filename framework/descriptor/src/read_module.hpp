// Reads a <module> element.
#pragma once

#include <string_view>
#include <vector>

#include <takt/model/cell.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

struct ModuleReading {
  model::Module module;
  bool name_known = true;  ///< false if the name could not be read
};

/// Reads a module. `executors` are the executors of the module's device, at least one. If there is only one,
/// a module without <executor> runs on this one.
ModuleReading read_module(const Node& xml, const std::vector<model::Executor>& executors, Report& report);

/// Returns true if <module> may contain an element with this name.
bool is_of_module(std::string_view name);

}  // namespace takt::descriptor
