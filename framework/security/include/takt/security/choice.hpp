// Chooses an identity if a folder with several identities is given.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

struct Chosen {
  std::string folder;
  Problems passed_over{};  ///< the problems of the identities before it
};

/// In a folder made by `takt secure init`: the folder of the first identity of this role, by name, that is
/// valid at this time (seconds since 1970). If none is valid, that of the first identity. In any other
/// folder: `folder` itself.
Chosen first_of(const std::string& folder, Role role, std::int64_t now);

}  // namespace takt::security
