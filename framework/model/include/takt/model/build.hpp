// The build of a component: its version and the hash of its file.
#pragma once

#include <string>

namespace takt::model {

/// Identifies the build of a component's file.
struct Build {
  std::string version{};  ///< the version that the component's author states; may be empty
  std::string hash{};     ///< the first 8 hexadecimal digits of the file's SHA-256; empty: not known

  bool operator==(const Build&) const = default;
};

/// Returns the known members as text: "1.2.0 3fa91c02", "3fa91c02", or an empty text.
inline std::string to_text(const Build& build) {
  return build.version + (build.version.empty() || build.hash.empty() ? "" : " ") + build.hash;
}

}  // namespace takt::model
