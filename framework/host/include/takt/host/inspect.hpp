// Describes and checks components before anything is started. A component is loaded in a child process,
// because its constructors are foreign code that may crash or hang.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/host/description.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::host {

/// The arguments of a program: its properties, each as "name=value", in the order of the descriptor.
using Arguments = std::vector<std::string>;
Arguments arguments_of(const model::Module& module);

/// Describes a component. A .so is loaded. A program that is linked with libtakt_process (or is a script) is
/// started with these arguments, on which its ports may depend, and is asked to report its description and
/// end at once. A program that does not report within 5 s, or calls neither initPeriodExe() nor
/// initSporadicExe(), has no ports; with arguments that is an error, with the program's own words about them.
/// `path` comes from find_component().
Result<Description> describe(const std::string& path, const Arguments& arguments = {});

/// The sentence in a component's file, from TAKT_TEXT() or TAKT_COMPONENT(); empty if there is none. The file
/// is neither loaded nor started.
std::string component_text(const std::string& path);

/// A file that may be a component, judged without loading or starting it.
struct ComponentFile {
  std::string path;
  std::string interface;  ///< "c++", "c" or "process"
  std::string text;       ///< may be empty
};
/// The components in these folders, sorted by file name. If two files have the same name, the first is
/// listed, as find_component() does. A missing folder counts as empty.
std::vector<ComponentFile> list_components(const std::vector<std::string>& folders);

/// The component file of each module of a device, by the module's index.
using ComponentPaths = std::vector<std::string>;

/// What was found out about a cell's components, by device and module.
struct Components {
  std::vector<ComponentPaths> paths;
  /// Known for every component that is on this machine and could be loaded. A program's ports are known only
  /// if a connection names it or the descriptor gives it properties.
  model::CellPorts ports;
};

/// Looks up and loads the component of every module. Checks that it exists, is of the kind that the
/// descriptor states, accepts its properties, and has the ports that connections name. Reports every problem
/// at once, each at the line of its module or connection. With `missing`, a file that is not on this machine
/// is added there instead of being a problem; its path is then empty and its ports are unknown.
Result<Components> check_components(const model::Cell& cell, Problems* missing = nullptr);

}  // namespace takt::host
