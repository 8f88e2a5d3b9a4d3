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

/// Describes a component. A .so is loaded. A program that is linked with libtakt_process, and also a script,
/// is started with these arguments, because its ports may depend on them; it reports its description and ends
/// at once. Without arguments, a program that does not report within 5 s is described without ports. With
/// arguments, a missing report is an error. If the program ends with an error message about its arguments,
/// that message is returned. `path` comes from find_component().
Result<Description> describe(const std::string& path, const Arguments& arguments = {});

/// The sentence that TAKT_TEXT() or TAKT_COMPONENT() put into a component's file; empty if there is none. The
/// file is neither loaded nor started.
std::string component_text(const std::string& path);

/// A file that may be a component, judged without loading or starting it.
struct ComponentFile {
  std::string path;
  std::string interface;  ///< "c++", "c" or "process"
  std::string text;       ///< may be empty
};
/// Lists the components in these folders, sorted by file name. If several folders have a file of the same
/// name, only the first is listed, because find_component() uses that one. A missing folder counts as empty.
std::vector<ComponentFile> list_components(const std::vector<std::string>& folders);

/// The component file of each module of a device, by the module's index.
using ComponentPaths = std::vector<std::string>;

/// What check_components() found out about a cell's components, by device and module.
struct Components {
  std::vector<ComponentPaths> paths;
  /// The ports are known for every component that is on this machine and could be loaded. A program's ports
  /// are known only if a connection names the program or the descriptor gives it properties or a safe state.
  model::CellPorts ports;
};

/// Looks up and loads the component of every module. Checks that the component exists, is of the kind that
/// the descriptor states, accepts its properties, and has the ports that connections name. Reports all
/// problems together, each at the line of its module, property or connection. If `missing` is not null,
/// problems about files that find_component() rejects go there; the paths of these files are empty and their
/// ports unknown.
Result<Components> check_components(const model::Cell& cell, Problems* missing = nullptr);

}  // namespace takt::host
