// Looks up the file of a component.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>
#include <takt/os/process.hpp>

namespace takt::host {

/// Returns the folders in which find_component() searches for a relative file name after the descriptor's
/// folder: first the folders of TAKT_COMPONENT_PATH (separated by ':'), then the components folder installed
/// or built with this program.
std::vector<std::string> component_folders();

/// Returns the absolute path of a component's file. An absolute name is used unchanged. Any other name is
/// searched for, exactly as written, in the descriptor's folder and then in each of component_folders(). So a
/// name with a folder never finds a file of the same name in another folder. If there is no such file, the
/// error names the folders, or the paths, that were tried. Also fails if open_component() fails.
Result<std::string> find_component(const std::string& filename, const std::string& descriptor);

/// Like find_component(), but searches only component_folders(), and accepts no file outside them, because
/// the name comes from another machine. Does not check the file; pass the resulting path to find_component()
/// for this.
Result<std::string> find_on_component_path(const std::string& filename);

/// A check of a component's file at `path`. `content` is a copy of the file that nobody can change.
using ComponentCheck = std::function<Result<void>(const std::string& path, const os::Fd& content)>;
/// Adds a check that each component must pass whenever it is found, loaded or started. Call this before other
/// threads start.
void require_of_components(ComponentCheck check);

/// Checks the file of a component immediately before it is loaded or started. Fails if other users can
/// replace the file (os::check_writers()), or if the check of require_of_components() fails. Returns the copy
/// of the file that passed this check. The caller must load or start the copy, because the file may have
/// changed since. Without a check there is no copy, and the caller uses the file itself.
Result<os::Fd> open_component(const std::string& path);

/// Starts the program of a component after open_component(). `options.program` is the path of its file.
Result<os::Child> start_component(os::SpawnOptions options);

}  // namespace takt::host
