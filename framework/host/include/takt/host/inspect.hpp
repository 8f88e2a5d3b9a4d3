// What a component is, found out before anything is started. The component is loaded in a child process,
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

/// What a program is started with: its properties, "name=value" each, in the order of the descriptor.
using Arguments = std::vector<std::string>;
Arguments arguments_of(const model::Module& module);

/// Loads a .so and says what it is. A program that is linked with libtakt_process (or is a script) is started
/// with these arguments, on which its ports may depend, and with what tells it to say what it is and end at
/// once. One that has not done so within 5 s, or does not call initPeriodExe() or initSporadicExe(), has no
/// ports; with arguments that is an error: what the program said of them. `path` as from find_component().
Result<Description> describe(const std::string& path, const Arguments& arguments = {});

/// The sentence of a component's file, TAKT_TEXT() or of TAKT_COMPONENT(); empty when it has none. Nothing of
/// the file is loaded or started.
std::string component_text(const std::string& path);

/// A file that may be a component, known without loading or starting it.
struct ComponentFile {
  std::string path;
  std::string interface;  ///< "c++", "c" or "process"
  std::string text;       ///< may be empty
};
/// The components in these folders, each by the name of its file; of two of one name the first, as
/// find_component() does. A folder that is not there has none.
std::vector<ComponentFile> list_components(const std::vector<std::string>& folders);

/// The files of a device's modules, by the module's index.
using ComponentPaths = std::vector<std::string>;

/// What was found of a cell's components, by device and module.
struct Components {
  std::vector<ComponentPaths> paths;
  /// Known for every component that is here and could be loaded; of a program where a connection names it or
  /// the descriptor gives it properties.
  model::CellPorts ports;
};

/// Looks up and loads the component of every module: whether it is there, is what the descriptor says it is,
/// takes the properties that it is given, and has the ports that connections name. Every problem at once,
/// each at its module's or connection's line. With `missing`, a file that is not on this machine goes there
/// and is no problem; its path is empty then, and nothing is known of its ports.
Result<Components> check_components(const model::Cell& cell, Problems* missing = nullptr);

}  // namespace takt::host
