// Chooses an identity if the user names a folder with several identities.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

struct Chosen {
  std::string folder;
  Problems passed_over{};  ///< the problems of the identities that were rejected before this one
};

/// Returns the folder of one identity. If `takt secure init` created `folder`, chooses an identity with this
/// role: the first one, in the order of names, that is valid at the time `now` (in seconds since 1970), or
/// simply the first one if none is valid. If `folder` contains no identity of this role, returns `folder`
/// itself.
Chosen first_of(const std::string& folder, Role role, std::int64_t now);

}  // namespace takt::security
