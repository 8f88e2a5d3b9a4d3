// Pick and place positions for dispatcher, in the frame of the robot's foot. SI units.
#pragma once

#include <cstdint>

namespace dispatcher {

struct Position {
  double x = 0;
  double y = 0;
  double z = 0;
};

/// A pallet with `columns` places along x and `rows` places along y, `pitch` m apart. After the last place,
/// the first place is next, as on an empty pallet.
struct Pallet {
  Position first;
  std::int64_t columns = 4;
  std::int64_t rows = 3;
  double pitch = 0.12;

  /// Returns the place of part `n`; the first part has the number 0.
  [[nodiscard]] Position slot(std::uint64_t n) const noexcept {
    const auto place = n % static_cast<std::uint64_t>(columns * rows);
    const auto column = place % static_cast<std::uint64_t>(columns);
    const auto row = place / static_cast<std::uint64_t>(columns);
    return {first.x + pitch * static_cast<double>(column), first.y + pitch * static_cast<double>(row),
            first.z};
  }
};

}  // namespace dispatcher
