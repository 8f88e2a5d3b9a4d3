// The position loop of an axis, as a thread module in the form of the paper's Figure 8. Its period comes from
// the descriptor.
#include <takt/module.h>

#include <cstdio>

#include "position_loop.hpp"

TAKT_TEXT("Position loop of a linear axis that moves back and forth on a trapezoidal profile.");
TAKT_INTEGER(counter, 5, 1, 1000000, "periods",
             "Periods with an error of at most 0.01 mm before the axis is in position.");
TAKT_NUMBER(stroke_mm, 100, 1, 10000, "mm", "Distance between the ends.");
TAKT_NUMBER(velocity_mm_s, 500, 1, 5000, "mm/s", "Maximum velocity of the profile.");
TAKT_NUMBER(acceleration_mm_s2, 5000, 10, 100000, "mm/s^2", "Acceleration of the profile.");
TAKT_NUMBER(gain_1_s, 60, 1, 200, "1/s", "Proportional gain.");
TAKT_NUMBER(integral_1_s2, 800, 0, 5000, "1/s^2", "Integral gain.");

namespace {

controller1::Shuttle shuttle;
int errors = 0;

}  // namespace

extern "C" {

void initialize(irp::Property const&) {
  shuttle.in_position.counter = counter;
  shuttle.stroke = stroke_mm;
  shuttle.move.velocity = velocity_mm_s;
  shuttle.move.acceleration = acceleration_mm_s2;
  shuttle.loop.gain = gain_1_s;
  shuttle.loop.integral_gain = integral_1_s2;
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
