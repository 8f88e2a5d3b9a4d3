// Chooses offsets for an executor's modules so that the fullest row is as light as possible.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::schedule {

/// A module of the table to flatten.
struct Shiftable {
  Nanoseconds period{};     ///< > 0
  Nanoseconds offset{};     ///< if `fixed`: at least 0 and less than the period
  bool fixed = false;       ///< the module keeps its offset
  std::int64_t weight = 1;  ///< the load that it adds to a row, 1 to 2^40
};

/// The offsets of all modules, in their order. Fixed offsets stay; the others are multiples of the greatest
/// common divisor of all periods and fixed offsets, so that the table keeps its basic period. A search makes
/// the heaviest row as light as possible. For small tables it finds the optimum; for large tables it stops
/// after a fixed number of steps. The result is never worse than without shifts. If it is no better, all free
/// offsets are 0. Of equally good results, the search takes the one with the earliest offsets, module by
/// module. The same input gives the same result. Allocates; takes at most some tens of milliseconds.
std::vector<Nanoseconds> flatten(std::span<const Shiftable> modules);

}  // namespace takt::schedule
