// Where the file of a component is found.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::host {

/// The folders that a relative file name is looked up in, after the descriptor's own: those of
/// TAKT_COMPONENT_PATH (separated by ':'), then the one that was installed or built with this program.
std::vector<std::string> component_folders();

/// The path of a regular file. An absolute name is taken as it is; a relative one is looked up beside the
/// descriptor, then in each folder, there first as written and then by its last part (a folder of components
/// is flat). Fails with the places that were tried; also where others may write the file or its folder, and
/// where it is not as require_of_components() has it.
Result<std::string> find_component(const std::string& filename, const std::string& descriptor);

/// What else holds of every component's file that find_component() gives. While there is one thread.
void require_of_components(std::function<Result<void>(const std::string& path)> check);

}  // namespace takt::host
