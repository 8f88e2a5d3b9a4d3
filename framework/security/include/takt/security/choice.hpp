// Whose identity it is where a whole folder of them is named.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

struct Chosen {
  std::string folder;
  Problems passed_over{};  ///< what is wrong with those before it
};

/// Below a folder that `takt secure init` made: of the first of this role, by name, whose identity is in
/// order at this time (seconds since 1970); of the very first where none is. Else `folder` itself.
Chosen first_of(const std::string& folder, Role role, std::int64_t now);

}  // namespace takt::security
