// Where the releases of an executor's modules are shifted to, so that its fullest row is as light as
// possible.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::schedule {

/// One module of a table that is to be flattened.
struct Shiftable {
  Nanoseconds period{};
  Nanoseconds offset{};     ///< where it is fixed, 0 to below the period
  bool fixed = false;       ///< it stays at its offset
  std::int64_t weight = 1;  ///< what it adds to a row, 1 to 2^40
};

/// The offsets of all, in their order: the fixed ones as given, the others multiples of the greatest common
/// divisor of all periods and fixed offsets, so that the table keeps its basic period. The heaviest row is as
/// light as a search finds that is exact where the table is small and otherwise ends at a good one; the same
/// input has the same answer. Of equally good ones the earliest offsets, module by module. Never worse than
/// without a shift: then all that are not fixed are 0. Every period is positive. Allocates; takes at most
/// some tens of milliseconds.
std::vector<Nanoseconds> flatten(std::span<const Shiftable> modules);

}  // namespace takt::schedule
