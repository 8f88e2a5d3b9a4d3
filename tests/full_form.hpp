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

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// How often something is tried. Under sanitizers it takes ten times as long, so in the short form there is a
/// tenth of it.
inline int how_often(int all) { return kSanitized && !full_form() ? all / 10 : all; }

}  // namespace takt
