// The mathematics of emergency: the winding temperature of a motor and its limit. Temperatures are in kelvin
// above the room, currents in amperes, times in seconds. Everything here is real-time.
#pragma once

#include <cmath>
#include <cstdint>

namespace emergency {

/// One thermal mass, heated by the square of the current.
struct Winding {
  double time_constant = 0.4;  ///< s; the winding of a servo motor, without the housing
  double heating = 1.5;        ///< K/A^2 in the steady state
  double temperature = 0;      ///< K above the room

  void step(double current, double dt) noexcept {
    temperature += (heating * current * current - temperature) * (1 - std::exp(-dt / time_constant));
  }
};

/// A limit with hysteresis. An edge stays pending until it is served, so none is lost if run() is late or
/// skipped.
struct Limit {
  double trip = 90;
  double clear = 60;
  bool tripped = false;

  /// Whether there is an edge to serve: the value has reached `trip`, or after a trip it has fallen to
  /// `clear`.
  [[nodiscard]] bool pending(double value) const noexcept { return tripped ? value <= clear : value >= trip; }
  void serve() noexcept { tripped = !tripped; }
};

/// A motor that overheats: it runs until the limit trips and rests until the limit clears.
struct Drive {
  Winding winding{};
  Limit limit{};
  double current = 10;  ///< A, while not tripped
  double hottest = 0;
  std::uint64_t trips = 0;

  /// Steps the motor. Returns true if there is an edge to serve.
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
