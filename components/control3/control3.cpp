// A thread module in the form of the paper's Figure 8, with a period of 100 us: removes the resonance of a
// joint from the joint's torque command, with a notch filter and a low-pass filter.
#include <takt/module.h>

#include <cstdio>

#include "filter.hpp"

TAKT_TEXT("Notch and low-pass filters that keep a joint's resonance out of its torque command.");
TAKT_NUMBER(resonance_hz, 180, 1, 4999, "Hz", "Frequency of the simulated resonance.");
TAKT_NUMBER(notch_hz, 180, 1, 4999, "Hz", "Frequency that the notch removes.");
TAKT_NUMBER(notch_quality, 2, 0.1, 100, "1", "Frequency of the notch divided by its width.");
TAKT_NUMBER(low_pass_hz, 1000, 1, 4999, "Hz", "Cut-off frequency of the low-pass filter.");
TAKT_NUMBER(command_hz, 2, 0.01, 100, "Hz", "Frequency of the sinusoidal torque command.");

namespace {

constexpr double kRate = 10000;  // Hz, fixed, because the interface of Figure 8 does not pass the period
constexpr double kTorque = 10;   // N m, amplitude of the torque command
constexpr double kRipple = 2;    // N m, amplitude of the ripple

control3::Biquad notch;
control3::Biquad low_pass;
control3::Oscillator command;
control3::Oscillator resonance;
control3::Detector before;
control3::Detector after;
double output = 0;  // N m, the command after the filters
int errors = 0;

}  // namespace

extern "C" {

void initialize(irp::Property const&) {
  notch = control3::Biquad::notch(notch_hz, notch_quality, kRate);
  low_pass = control3::Biquad::low_pass(low_pass_hz, 0.7071, kRate);
  command = control3::Oscillator(command_hz, kRate);
  resonance = control3::Oscillator(resonance_hz, kRate);
}

void start(void) {
  notch.reset();
  low_pass.reset();
}

void run(void) {
  const double torque = kTorque * command.step() + kRipple * resonance.step();
  output = low_pass.step(notch.step(torque));
  before.step(torque, resonance);
  after.step(output, resonance);
}

void error(int) { ++errors; }

void recover(void) { start(); }

void destruct(void) {
  std::fprintf(stderr, "control3: resonance %.3f N m before the filters, %.3f N m after them; %d errors\n",
               before.amplitude, after.amplitude, errors);
}
}
