// Where the file of a component is found.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::host {

/// The folders that a relative file name is looked up in, after the descriptor's own: those of
/// TAKT_COMPONENT_PATH (separated by ':'), then the one that was installed or built with this program.
std::vector<std::string> component_folders();

/// The path of a regular file. An absolute name is taken as it is; a relative one is looked up beside the
/// descriptor, then in each folder, there first as written and then by its last part (a folder of components
/// is flat). Fails with the places that were tried.
Result<std::string> find_component(const std::string& filename, const std::string& descriptor);

}  // namespace takt::host
