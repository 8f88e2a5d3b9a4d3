// The duration between two times of unknown origin, without overflow.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include <takt/core/time.hpp>

namespace takt {

/// The duration from `from_ns` to `to_ns`, in ns. Safe for any two numbers, for example from the network: a
/// duration that does not fit becomes the longest duration with the same sign. The result can always be
/// negated.
constexpr Nanoseconds span(std::int64_t from_ns, std::int64_t to_ns) {
  constexpr std::int64_t kLongest = std::numeric_limits<std::int64_t>::max();
  std::int64_t ns = 0;
  if (__builtin_sub_overflow(to_ns, from_ns, &ns)) ns = to_ns > from_ns ? kLongest : -kLongest;
  return Nanoseconds{std::max(ns, -kLongest)};
}

}  // namespace takt
