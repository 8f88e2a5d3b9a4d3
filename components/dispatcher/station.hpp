// Where parts are taken from and put down, seen from a robot's foot: what dispatcher says to it. SI units.
#pragma once

#include <cstdint>

namespace dispatcher {

struct Place {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// A pallet of `columns` along x and `rows` along y, `pitch` m apart. A full one is exchanged for an empty
/// one.
struct Pallet {
  Place first;
  std::int64_t columns = 4;
  std::int64_t rows = 3;
  double pitch = 0.12;

  /// Of the n-th part, from 0.
  [[nodiscard]] Place slot(std::uint64_t n) const noexcept {
    const auto place = n % static_cast<std::uint64_t>(columns * rows);
    const auto column = place % static_cast<std::uint64_t>(columns);
    const auto row = place / static_cast<std::uint64_t>(columns);
    return {first.x + pitch * static_cast<double>(column), first.y + pitch * static_cast<double>(row),
            first.z};
  }
};

}  // namespace dispatcher
