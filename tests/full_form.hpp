// What takes long has a short form in tools/test, and a full one in tools/test --full.
#pragma once

#include <cstdlib>
#include <string_view>

namespace takt {

/// Whether tests run in their full form: TAKT_TEST_FULL=1.
inline bool full_form() {
  const char* form = std::getenv("TAKT_TEST_FULL");
  return form != nullptr && std::string_view{form} == "1";
}

}  // namespace takt
