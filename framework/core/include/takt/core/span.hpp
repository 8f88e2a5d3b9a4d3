// Computes the duration between two arbitrary times without overflow.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include <takt/core/time.hpp>

namespace takt {

/// Returns the duration from `from_ns` to `to_ns`. Any two numbers are allowed, for example numbers that come
/// from the network: if the duration is too large, the result is the longest duration with the same sign. The
/// result can always be negated.
constexpr Nanoseconds span(std::int64_t from_ns, std::int64_t to_ns) {
  constexpr std::int64_t kLongest = std::numeric_limits<std::int64_t>::max();
  std::int64_t ns = 0;
  if (__builtin_sub_overflow(to_ns, from_ns, &ns)) ns = to_ns > from_ns ? kLongest : -kLongest;
  return Nanoseconds{std::max(ns, -kLongest)};
}

}  // namespace takt
