// What a component is, found out before anything is started. The component is loaded in a child process,
// because its constructors are foreign code that may crash or hang.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::host {

struct PropertyDescription {
  std::string name;
  std::string type;  ///< "bool", "integer", "double", "string"
  std::string default_value;
  std::string range;  ///< may be empty, as the two below
  std::string unit;
  std::string text;
};

struct Description {
  std::string name;                ///< of the class; of a C module, the file's stem
  std::string interface;           ///< "c++", "c" or "process"
  std::vector<std::string> hooks;  ///< of a C module
  std::vector<PropertyDescription> properties;
  std::vector<model::Port> ports;
};

/// What a program is started with: its properties, "name=value" each, in the order of the descriptor.
using Arguments = std::vector<std::string>;
Arguments arguments_of(const model::Module& module);

/// Loads a .so and says what it is. A program is started with these arguments, on which its ports may depend,
/// and with what tells it to say its ports and end at once. When it ends with a status that is not 0, what it
/// said on standard error are the problems. One that has not said its ports within 5 s, or does not call
/// initPeriodExe() or initSporadicExe(), has none; with arguments that is an error. `path` as from
/// find_component().
Result<Description> describe(const std::string& path, const Arguments& arguments = {});

/// The files of a device's modules, by the module's index.
using ComponentPaths = std::vector<std::string>;

/// What was found of a cell's components, by device and module.
struct Components {
  std::vector<ComponentPaths> paths;
  /// Known for every component that is here and could be loaded; of a program where a connection names it.
  model::CellPorts ports;
};

/// Looks up and loads the component of every module: whether it is there, is what the descriptor says it is,
/// takes the properties that it is given, and has the ports that connections name. Every problem at once,
/// each at its module's or connection's line. With `missing`, a file that is not on this machine goes there
/// and is no problem; its path is empty then, and nothing is known of its ports.
Result<Components> check_components(const model::Cell& cell, Problems* missing = nullptr);

}  // namespace takt::host
