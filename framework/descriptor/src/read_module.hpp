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
  bool name_known = true;  ///< false: its name could not be read
};

/// `executors` are those of the device, never empty. A module without <executor> gets the only executor.
ModuleReading read_module(const Node& xml, const std::vector<model::Executor>& executors, Report& report);

/// Whether a <module> may contain an element of this name.
bool is_of_module(std::string_view name);

}  // namespace takt::descriptor
