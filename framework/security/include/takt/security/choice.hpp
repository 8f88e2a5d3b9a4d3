// Chooses an identity if the user names a folder with several identities.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

struct Chosen {
  std::string folder;
  Problems passed_over{};  ///< the problems that ruled out the identities tried before
};

/// If `takt secure init` created `folder`, returns the folder of an identity of this role in it: the first
/// one, in order of names, that is valid at the time `now` (in seconds since 1970), or the very first one if
/// none is valid. Otherwise returns `folder` itself.
Chosen first_of(const std::string& folder, Role role, std::int64_t now);

}  // namespace takt::security
