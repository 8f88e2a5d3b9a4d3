// Spans between times that others gave.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include <takt/core/time.hpp>

namespace takt {

/// The span between two numbers that somebody else gave, who may have given anything: the longest one of its
/// sign where there is none so long. It may be negated.
constexpr Nanoseconds span(std::int64_t from_ns, std::int64_t to_ns) {
  constexpr std::int64_t kLongest = std::numeric_limits<std::int64_t>::max();
  std::int64_t ns = 0;
  if (__builtin_sub_overflow(to_ns, from_ns, &ns)) ns = to_ns > from_ns ? kLongest : -kLongest;
  return Nanoseconds{std::max(ns, -kLongest)};
}

}  // namespace takt
