// Computes the duration between two times, without overflow for any two numbers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include <takt/core/time.hpp>

namespace takt {

/// Returns the duration from `from_ns` to `to_ns`. Any two numbers are allowed, even numbers from an
/// untrusted source. If the duration does not fit into Nanoseconds, the result is the longest duration with
/// the same sign. The result can always be negated without overflow.
constexpr Nanoseconds span(std::int64_t from_ns, std::int64_t to_ns) {
  constexpr std::int64_t kLongest = std::numeric_limits<std::int64_t>::max();
  std::int64_t ns = 0;
  if (__builtin_sub_overflow(to_ns, from_ns, &ns)) ns = to_ns > from_ns ? kLongest : -kLongest;
  return Nanoseconds{std::max(ns, -kLongest)};
}

}  // namespace takt
