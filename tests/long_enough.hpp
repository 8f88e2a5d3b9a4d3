// The limit of a test that waits for an event.
#pragma once

#include <chrono>
#include <cstdlib>

namespace takt {

/// Returns a limit that is long enough for every event that a test waits for: one minute, and longer on a
/// slow machine (tests/run.py sets TAKT_TEST_SLOWNESS). Only a test that asserts a duration has another
/// limit.
inline std::chrono::milliseconds long_enough() {
  const char* slowness = std::getenv("TAKT_TEST_SLOWNESS");
  return std::chrono::milliseconds{
      static_cast<long>(60'000 * (slowness == nullptr ? 1.0 : std::atof(slowness)))};
}

}  // namespace takt
