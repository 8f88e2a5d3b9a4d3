// What a module looks like in XML.
#pragma once

#include <string_view>
#include <vector>

#include <takt/model/cell.hpp>
#include "report.hpp"
#include "tree.hpp"

namespace takt::descriptor {

struct ModuleReading {
  model::Module module;
  bool name_known = true;  ///< false: its name could not be read
};

/// `executors` are those of its device, never empty: a module that names none belongs to the only one.
ModuleReading read_module(const Node& xml, const std::vector<model::Executor>& executors, Report& report);

/// Whether an element of this name may stand in a module.
bool is_of_module(std::string_view name);

}  // namespace takt::descriptor
