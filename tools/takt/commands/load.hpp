// Loads a descriptor. Every command that takes a descriptor begins with this.
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

/// Reads and validates the descriptor, plans its tables and inspects every component. Reports all problems of
/// the file at once. With `missing`, components that are not on this machine are listed there and are not an
/// error.
Result<Loaded> load(const std::string& file, Problems* missing = nullptr);

/// Like load(), but does not inspect the components. For a cell whose devices run on other machines. `paths`
/// and `ports` are empty.
Result<Loaded> load_remote(const std::string& file);

/// Prints problems on standard error, one per line: `file:line: error: ...`.
void complain(const Problems& problems);
/// Prints problems in the same way and returns the exit status 1.
int refuse(const Problems& problems);

}  // namespace takt::tool
