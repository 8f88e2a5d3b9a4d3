// The simulation of the component gripper: two fingers that close on a part. SI units. Real-time threads may
// use everything here.
#pragma once

#include <algorithm>

namespace gripper {

struct Fingers {
  double stroke = 0.08;      ///< m, distance between the open fingers
  double speed = 0.1;        ///< m/s, rate of change of the width
  double part_width = 0.04;  ///< m, width of a part; the gripper cannot grip parts wider than `stroke`

  double width = 0.08;  ///< m
  bool holding = false;

  /// Opens the fingers at once.
  void reset() noexcept {
    width = stroke;
    holding = false;
  }

  /// Moves the fingers for `dt` s. Fingers whose distance is already less than the width of a part do not
  /// grip the part. If a held part disappears, the fingers close.
  void step(bool close, bool part_present, double dt) noexcept {
    const double before = width;
    const double wanted = close ? 0 : stroke;
    width += std::clamp(wanted - width, -speed * dt, speed * dt);
    const bool stopped = close && part_present && before >= part_width && width <= part_width;
    if (stopped) width = part_width;
    holding = stopped;
  }
};

}  // namespace gripper
