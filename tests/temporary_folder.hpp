// A folder for the files that a test writes.
#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include <takt/os/environment.hpp>

namespace takt {

/// Creates a folder for this process and returns its path. A folder that does not exist yet would be rejected,
/// because everybody may create it.
inline std::string temporary_folder(const std::string& name) {
  const std::string path = testing::TempDir() + "takt-" + name + "-" + std::to_string(os::process_id());
  std::filesystem::create_directories(path);
  return path;
}

}  // namespace takt
