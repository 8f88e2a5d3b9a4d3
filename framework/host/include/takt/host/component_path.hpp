// Looks up the file of a component.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::host {

/// The folders to search for a relative file name, after the descriptor's own folder: those of
/// TAKT_COMPONENT_PATH (separated by ':'), then the one that was installed or built with this program.
std::vector<std::string> component_folders();

/// The path of a regular file. An absolute name is used unchanged. A relative name is looked up beside the
/// descriptor, then in each folder: first as written, then by its last part, because component folders are
/// flat. An error lists the places that were tried. Also fails if everybody may write to the file or its
/// folder, or if the check of require_of_components() fails.
Result<std::string> find_component(const std::string& filename, const std::string& descriptor);

/// Adds a check that find_component() applies to every file it finds. Call it while there is only one thread.
void require_of_components(std::function<Result<void>(const std::string& path)> check);

}  // namespace takt::host
