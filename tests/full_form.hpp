// Long tests have a short form, which tools/test runs, and a full form, which tools/test --full runs.
#pragma once

#include <cstdlib>
#include <string_view>

namespace takt {

/// Returns whether tests run in their full form (TAKT_TEST_FULL=1).
inline bool full_form() {
  const char* form = std::getenv("TAKT_TEST_FULL");
  return form != nullptr && std::string_view{form} == "1";
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Returns how often a test repeats its work. Under sanitizers, the work takes ten times as long, so the short
/// form does a twentieth of it there.
inline int how_often(int all) { return kSanitized && !full_form() ? all / 20 : all; }

}  // namespace takt
