// What blocks ask of the module that they are: a period.
#pragma once

#include <takt/component.hpp>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace common {

/// Fails for a module without a period: a block counts time and makes its filters by it.
inline takt::Result<void> check_period(takt::Nanoseconds period) {
  if (period > takt::Nanoseconds{0}) return {};
  return takt::fail("it counts time in periods, and this module has none",
                    "make it periodic, with <operationtype>periodic</operationtype> and a <period>");
}

inline double in_seconds(takt::Nanoseconds span) { return std::chrono::duration<double>(span).count(); }
/// To six digits, as people write an end of a range.
inline double rounded(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return std::strtod(text.data(), nullptr);
}
/// The reason that stands behind a range which the period makes.
inline std::string at_period(takt::Nanoseconds period) { return "at a period of " + takt::to_text(period); }

}  // namespace common
