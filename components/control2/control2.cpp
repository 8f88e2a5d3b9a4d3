// The velocity loop of a DC motor, as a thread module in C++ with a period of 100 us. The set point is a
// sine, and a load switches on and off.
#include <takt/component.hpp>

#include <cstdio>
#include <numbers>

#include "velocity_loop.hpp"

class Control2 : public takt::Component {
  takt::Property<double> gain{
      *this, "gain", 0.2, {.unit = "V s/rad", .min = 0, .max = 10, .text = "Proportional gain."}};
  takt::Property<double> integral{
      *this, "integral", 10, {.unit = "V/rad", .min = 0, .max = 1000, .text = "Integral gain."}};
  takt::Property<double> derivative{
      *this, "derivative", 0, {.unit = "V s^2/rad", .min = 0, .max = 0.01, .text = "Derivative gain."}};
  takt::Property<double> voltage{
      *this, "voltage", 24, {.unit = "V", .min = 1, .max = 60, .text = "Voltage limit of the amplifier."}};
  takt::Property<double> amplitude{
      *this,
      "amplitude",
      200,
      {.unit = "rad/s", .min = 0, .max = 1000, .text = "Amplitude of the speed set point."}};
  takt::Property<double> frequency{
      *this,
      "frequency",
      1,
      {.unit = "Hz", .min = 0.01, .max = 50, .text = "Frequency of the speed set point."}};
  takt::Property<double> load{
      *this,
      "load",
      0.1,
      {.unit = "N m", .min = 0, .max = 2, .text = "Load torque; on for 0.5 s, then off for 0.5 s."}};

  control2::Motor motor_;
  control2::Pid pid_;
  control2::ErrorMeter meter_;
  double phase_ = 0;  // phase of the set point, in periods, 0 to 1
  double time_ = 0;   // s since the load last switched off, 0 to 1
  unsigned long long limited_ = 0;
  unsigned long long runs_ = 0;

  takt::Result<void> start() override { return recover(); }

  void run(const takt::Cycle& cycle) noexcept override {
    const double dt = cycle.seconds();
    phase_ += frequency * dt;
    phase_ -= std::floor(phase_);
    time_ = time_ >= 1 ? 0 : time_ + dt;
    motor_.load = time_ < 0.5 ? 0 : load.value();

    // Copies the gains in each release, so that a gain that is set while the module runs takes effect at the
    // next release.
    pid_.gain = gain;
    pid_.integral_gain = integral;
    pid_.derivative_gain = derivative;
    pid_.limit = voltage;
    const double wanted = amplitude * std::sin(2 * std::numbers::pi * phase_);
    const double output = pid_.step(wanted, motor_.speed, dt);
    motor_.step(output, dt);
    meter_.step(wanted - motor_.speed, dt);
    limited_ += std::abs(output) >= voltage ? 1 : 0;
    ++runs_;
  }

  takt::Result<void> recover() override {
    motor_.current = motor_.speed = 0;
    pid_.reset();
    phase_ = time_ = 0;
    return {};
  }

  void destruct() override {
    std::fprintf(stderr,
                 "control2: speed error %.2f rad/s rms, %.2f at most; amplifier at its limit in %llu of %llu "
                 "periods\n",
                 std::sqrt(meter_.mean_square), meter_.largest, limited_, runs_);
  }
};
TAKT_COMPONENT(Control2, "Velocity loop of a DC motor with a load that switches on and off.")
