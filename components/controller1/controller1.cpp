// A thread module in the form of the paper's Figure 8: the position loop of an axis, at the period of the
// descriptor.
#include <takt/module.h>

#include <cstdio>

#include "position_loop.hpp"

namespace {

controller1::Shuttle shuttle;
int errors = 0;

}  // namespace

extern "C" {

void initialize(irp::Property const& property) {
  shuttle.in_position.counter = property.get("counter", 5LL, 1, 1000000);
  shuttle.stroke = property.get("stroke_mm", 100.0, 1, 10000);
  shuttle.move.velocity = property.get("velocity_mm_s", 500.0, 1, 5000);
  shuttle.move.acceleration = property.get("acceleration_mm_s2", 5000.0, 10, 100000);
  shuttle.loop.gain = property.get("gain_1_s", 60.0, 1, 200);
  shuttle.loop.integral_gain = property.get("integral_1_s2", 800.0, 0, 5000);
  shuttle.loop.command_limit = 1.2 * shuttle.move.velocity;
}

void start(void) { shuttle.begin(); }

void run(void) { shuttle.step(static_cast<double>(takt_period_ns()) * 1e-9); }

void error(int) { ++errors; }

void recover(void) { shuttle.begin(); }

void destruct(void) {
  std::fprintf(
      stderr,
      "controller1: %llu moves of %g mm, following error at most %.3f mm, in position after at most %.1f ms, "
      "%d errors\n",
      static_cast<unsigned long long>(shuttle.moves), shuttle.stroke, shuttle.largest_error,
      shuttle.settling * 1e3, errors);
}
}
