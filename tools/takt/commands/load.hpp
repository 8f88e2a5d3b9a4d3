// The first step of every command that takes a descriptor.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::tool {

struct Loaded {
  std::string text;  ///< of the descriptor
  model::Cell cell;
  std::vector<schedule::DevicePlan> plans;
  std::vector<host::ComponentPaths> paths;
  model::CellPorts ports;
};

/// Reads, validates, plans, and looks at every component; every problem of the file at once. With `missing`,
/// component files that are not on this machine go there and are no problem.
Result<Loaded> load(const std::string& file, Problems* missing = nullptr);

/// The same without the components: for a cell whose devices are other machines. No paths then.
Result<Loaded> load_remote(const std::string& file);

/// Prints problems as `file:line: error: ...`, one a line, on standard error.
void complain(const Problems& problems);
/// Prints them in the same way and returns the exit status 1.
int refuse(const Problems& problems);

}  // namespace takt::tool
