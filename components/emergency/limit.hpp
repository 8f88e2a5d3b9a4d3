// The mathematics of the component emergency: the winding temperature of a motor and its limit. Temperatures
// are in kelvin above ambient, currents in amperes, times in seconds. Real-time threads may use everything
// here.
#pragma once

#include <cmath>
#include <cstdint>

namespace emergency {

/// A motor winding as one thermal mass, which the square of the current heats.
struct Winding {
  double time_constant = 0.4;  ///< s; for the winding of a servo motor without its housing
  double heating = 1.5;        ///< K/A^2, temperature rise in the steady state
  double temperature = 0;      ///< K above ambient

  void step(double current, double dt) noexcept {
    temperature += (heating * current * current - temperature) * (1 - std::exp(-dt / time_constant));
  }
};

/// A limit with hysteresis. An edge stays pending until serve() is called, so no edge is lost if run() is
/// late or skipped.
struct Limit {
  double trip = 90;
  double clear = 60;
  bool tripped = false;

  /// Returns true if an edge is pending: the value has reached `trip`, or after a trip it has fallen to
  /// `clear`.
  [[nodiscard]] bool pending(double value) const noexcept { return tripped ? value <= clear : value >= trip; }
  void serve() noexcept { tripped = !tripped; }
};

/// A motor that overheats. The motor runs until the limit trips, and rests until the limit clears.
struct Drive {
  Winding winding{};
  Limit limit{};
  double current = 10;  ///< A, current while the motor runs
  double hottest = 0;
  std::uint64_t trips = 0;

  /// Simulates the motor for `dt` s. Returns true if an edge is pending.
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
