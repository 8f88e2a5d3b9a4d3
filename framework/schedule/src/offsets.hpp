// Chooses offsets for an executor's modules so that the load of the fullest row is as small as possible.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::schedule {

/// A module for which an offset may be chosen.
struct Shiftable {
  Nanoseconds period{};     ///< > 0
  Nanoseconds offset{};     ///< if `fixed` is true: the offset; at least 0 and less than the period
  bool fixed = false;       ///< true if the module keeps its offset
  std::int64_t weight = 1;  ///< the load that the module adds to a row, 1 to 2^40
};

/// Returns the offsets of all modules, in the order of `modules`. Fixed offsets do not change. All other
/// offsets are multiples of the greatest common divisor of all periods and fixed offsets, so that the basic
/// period of the table does not change. A search makes the load of the heaviest row as small as possible. For
/// small tables, the search finds the optimum; for large tables, it stops after a fixed number of steps. The
/// result is never worse than with all free offsets at 0. If the search finds nothing better, all free
/// offsets are 0. Of several equally good results, the search returns the one with the earliest offsets,
/// module by module. The same input always gives the same result. Allocates memory; takes up to some tens of
/// milliseconds.
std::vector<Nanoseconds> flatten(std::span<const Shiftable> modules);

}  // namespace takt::schedule
