// Chooses an identity if a folder with several identities is given.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

struct Chosen {
  std::string folder;
  Problems passed_over{};  ///< the problems of the identities before the chosen one
};

/// If `folder` was made by `takt secure init`, returns the folder of an identity of this role in it: the
/// first one, by name, that is valid at this time (seconds since 1970), or the first one if none is valid.
/// Returns any other `folder` itself.
Chosen first_of(const std::string& folder, Role role, std::int64_t now);

}  // namespace takt::security
