// What a component is, found out before anything is started. The component is loaded in a child process,
// because its constructors are foreign code that may crash or hang.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

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
};

/// Loads a .so and says what it is; a program is only looked at. `path` as from find_component().
Result<Description> describe(const std::string& path);

/// The files of a device's modules, by the module's index.
using ComponentPaths = std::vector<std::string>;

/// Looks up and loads the component of every module: whether it is there, is what the descriptor says it is,
/// and takes the properties that it is given. Every problem at once, each at its module's line. With
/// `missing`, a file that is not on this machine goes there and is no problem; its path is empty then.
Result<std::vector<ComponentPaths>> check_components(const model::Cell& cell, Problems* missing = nullptr);

}  // namespace takt::host
