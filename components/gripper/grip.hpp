// Two fingers that close on a part: what gripper simulates. SI units. For real-time threads.
#pragma once

#include <algorithm>

namespace gripper {

struct Fingers {
  double stroke = 0.08;      ///< m, between the fingers when they are open
  double speed = 0.1;        ///< m/s, of the width
  double part_width = 0.04;  ///< m, of a part that is there; more than the stroke cannot be gripped

  double width = 0.08;  ///< m
  bool holding = false;

  /// Open fingers, at rest.
  void reset() noexcept {
    width = stroke;
    holding = false;
  }

  /// One that comes between fingers that are closer than it is wide is not gripped; one that is gone is not
  /// held any more, and the fingers go on.
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
