// Looks up the file of a component.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::host {

/// The folders that are searched for a relative file name after the descriptor's folder: first the folders of
/// TAKT_COMPONENT_PATH (separated by ':'), then the components folder installed or built with this program.
std::vector<std::string> component_folders();

/// Returns the path of a component's file. An absolute name is used unchanged. A relative name is searched
/// for in the descriptor's folder, then in each of component_folders(): first as written, then by its last
/// part, because component folders are flat. The error lists the folders that were searched. Also fails if
/// everybody may write to the file or its folder, or if the check of require_of_components() fails.
Result<std::string> find_component(const std::string& filename, const std::string& descriptor);

/// Adds a check that find_component() applies to every file it finds. Call this before other threads start.
void require_of_components(std::function<Result<void>(const std::string& path)> check);

}  // namespace takt::host
