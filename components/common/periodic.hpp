// Helpers for components that need a period.
#pragma once

#include <takt/component.hpp>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace common {

/// Checks that the module has a period. The component needs the period to count time and to design its
/// filters.
inline takt::Result<void> check_period(takt::Nanoseconds period) {
  if (period > takt::Nanoseconds{0}) return {};
  return takt::fail("this module has no period, but the component needs one",
                    "make it periodic, with <operationtype>periodic</operationtype> and a <period>");
}

inline double in_seconds(takt::Nanoseconds span) { return std::chrono::duration<double>(span).count(); }
/// Rounds a limit of a property's range to six digits.
inline double rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return std::strtod(text.data(), nullptr);
}
/// Returns the words that explain why a range depends on the period.
inline std::string at_period(takt::Nanoseconds period) { return "at a period of " + takt::to_text(period); }

}  // namespace common
