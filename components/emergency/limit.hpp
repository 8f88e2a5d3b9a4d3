// The winding temperature of a motor and the limit on it: what emergency computes, without the module around
// it. Kelvin above the room's temperature, amperes, seconds. Everything here is for real-time threads.
#pragma once

#include <cmath>
#include <cstdint>

namespace emergency {

/// One thermal mass that is heated by the square of the current.
struct Winding {
  double time_constant = 0.4;  ///< s; a winding of a servo motor, without its housing
  double heating = 1.5;        ///< K/A^2 in the steady state
  double temperature = 0;      ///< K above the room

  void step(double current, double dt) noexcept {
    temperature += (heating * current * current - temperature) * (1 - std::exp(-dt / time_constant));
  }
};

/// A limit with hysteresis. An edge stays pending until it is served, so none is lost when run() comes late
/// or not at all.
struct Limit {
  double trip = 90;
  double clear = 60;
  bool tripped = false;

  /// Whether there is an edge to serve: the limit is reached and has not tripped, or has tripped and the
  /// value is low again.
  [[nodiscard]] bool pending(double value) const noexcept { return tripped ? value <= clear : value >= trip; }
  void serve() noexcept { tripped = !tripped; }
};

/// The motor that overheats: it runs until the limit trips, rests until it clears.
struct Drive {
  Winding winding{};
  Limit limit{};
  double current = 10;  ///< A, while not tripped
  double hottest = 0;
  std::uint64_t trips = 0;

  /// One step of the motor; whether the emergency has something to do.
  bool condition(double dt) noexcept {
    winding.step(limit.tripped ? 0 : current, dt);
    if (winding.temperature > hottest) hottest = winding.temperature;
    return limit.pending(winding.temperature);
  }

  void react() noexcept {
    limit.serve();
    if (limit.tripped) ++trips;
  }
};

}  // namespace emergency
