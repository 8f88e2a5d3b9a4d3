// Describes and checks components before anything is started. Each component is loaded in a child process,
// because the constructors of a component are foreign code that may crash or hang.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/module.h>
#include <takt/core/result.hpp>
#include <takt/host/description.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::host {

/// Returns the properties that the descriptor gives to the module itself: all except kLogLevelProperty.
irp::Property::Values values_of(const model::Module& module);

/// The command-line arguments of a program: the arguments in the descriptor, then the properties of
/// values_of() as "name=value", both in the order of the descriptor.
using Arguments = std::vector<std::string>;
Arguments arguments_of(const model::Module& module);

/// Describes a component. A .so is loaded. A program that is linked with libtakt_process, and also a script,
/// is started with these arguments, because its ports may depend on them. The program reports its description
/// and ends at once. If it does not report within 5 s, this is an error; but without arguments, a script is
/// then described without ports. If the program ends with an error message about its arguments, the result is
/// that error. `path` comes from find_component().
Result<Description> describe(const std::string& path, const Arguments& arguments = {});

/// Returns the sentence that TAKT_TEXT() or TAKT_COMPONENT() put into a component's file; empty if there is
/// none. Neither loads nor starts the file.
std::string component_text(const std::string& path);

/// Returns the version that TAKT_COMPONENT_VERSION() put into a component's file; empty if there is none.
/// Neither loads nor starts the file.
std::string component_version(const std::string& path);

/// Returns one problem for each function of a module in C whose name is nearly that of a hook that the module
/// does not define, for example `initialise`. Takt would never call it. Neither loads nor starts the file.
Problems misspelt_hooks(const std::string& path);

/// A file that looks like a component. It was neither loaded nor started.
struct ComponentFile {
  std::string path;
  std::string interface;  ///< "c++", "c" or "process"
  std::string text;       ///< may be empty
};
/// Lists the components in these folders, sorted by file name. If several folders have a file of the same
/// name, the list contains only the first, because find_component() uses the first. A missing folder counts
/// as empty.
std::vector<ComponentFile> list_components(const std::vector<std::string>& folders);

/// The path of each module's component file, by the module's index on its device.
using ComponentPaths = std::vector<std::string>;

/// The results of check_components() about the components of a cell, by device and module.
struct Components {
  std::vector<ComponentPaths> paths;
  /// The ports are known for every component that is on this machine and could be loaded. The ports of a
  /// non-real-time program are known only if a connection names the program or the descriptor gives it a safe
  /// state.
  model::CellPorts ports;
};

/// Looks up and loads the component of every module. Checks that the component exists, is of the kind that
/// the descriptor states (a periodic program calls initPeriodExe(), a sporadic one initSporadicExe()),
/// accepts its properties, and has the ports that connections name. Reports all problems together, each at
/// the line of its module, property or connection. If `missing` is not null, problems about files that
/// find_component() rejects are added to `*missing` instead. Then the paths of these files are empty, and
/// their ports are unknown.
Result<Components> check_components(const model::Cell& cell, Problems* missing = nullptr);

/// Finds misspelled file names in a cell that was rejected. A module without a given name has the name of its
/// file. If a connection or service names a similar module, and the file does not exist, the result contains
/// a problem for the file. For example, with <filename>Servo.so</filename> the cell has no module `servo`, so
/// the connections to it are wrong, but the mistake is in the <filename>.
Problems misnamed_files(const model::Cell& rejected);

}  // namespace takt::host
