// Loads a descriptor, for the commands that take one.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::tool {

struct Loaded {
  std::string text;  ///< the text of the descriptor
  model::Cell cell;
  std::vector<schedule::DevicePlan> plans;
  std::vector<host::ComponentPaths> paths;
  model::CellPorts ports;
};

/// Reads and validates the descriptor, plans its tables and inspects every component. Reports all problems of
/// the file at once. If `missing` is given, a component that is not on this machine is added to `missing` and
/// is not an error.
Result<Loaded> load(const std::string& file, Problems* missing = nullptr);

/// Like load(), but does not inspect the components, which may be on other machines. `paths` and `ports` are
/// empty.
Result<Loaded> load_remote(const std::string& file);

/// Prints problems on standard error, one per line: `file:line: error: ...`.
void complain(const Problems& problems);
/// Prints warnings on standard error, one per line: `file:line: warning: ...`.
void warn(const Problems& warnings);
/// Prints problems like complain(), and returns 1, the exit status of the command.
int refuse(const Problems& problems);

}  // namespace takt::tool
