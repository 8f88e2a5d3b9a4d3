// The hash by which users tell two builds of a component apart.
#pragma once

#include <string>

namespace takt::security {

/// Returns the first 8 hexadecimal digits of the SHA-256 of the file, as `sha256sum` prints them. The result
/// is empty if the file cannot be read.
std::string short_hash(const std::string& file);

}  // namespace takt::security
