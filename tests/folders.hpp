// The files that tests read, in the source folder and in the build folder.
//
// Only the generated file folders.cpp contains the paths of these folders, so that the compiler cache can
// reuse everything else for a clone in another folder.
#pragma once

#include <string>
#include <string_view>

namespace takt {

/// Returns the absolute path of a file whose path in the source folder is `file`, for example
/// "deploy/module.xml".
std::string source_path(std::string_view file);

/// Returns the absolute path of a file whose path in the build folder is `file`, for example "bin/takt-host".
std::string build_path(std::string_view file);

}  // namespace takt
