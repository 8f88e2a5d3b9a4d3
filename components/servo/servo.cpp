// A thread module in C++: the position loop of a six-axis arm.
#include <takt/component.hpp>

#include <cmath>

#include <motion.hpp>

#include "joint_servo.hpp"

class Servo : public takt::Component {
  takt::InPort<motion::JointState> setpoint{*this, "setpoint", {.text = "Where the axes are to be."}};
  takt::InPort<motion::JointState> measured{*this, "measured", {.text = "Where they are."}};
  takt::OutPort<motion::JointEffort> effort{*this, "effort", {.text = "What the drives are to give."}};
  takt::Property<double> stiffness{
      *this,
      "stiffness",
      10000,
      {.unit = "N m/rad", .min = 0, .max = 100000, .text = "Of the position loop."}};
  takt::Property<double> damping{
      *this, "damping", 600, {.unit = "N m s/rad", .min = 0, .max = 10000, .text = "Of the velocity error."}};
  takt::Property<double> limit{
      *this, "limit", 2000, {.unit = "N m", .min = 1, .max = 100000, .text = "What a drive can give."}};
  takt::Property<double> following{
      *this,
      "following",
      0.3,
      {.unit = "rad", .min = 0.001, .max = 3, .text = "An axis that is farther off than this is an error."}};

  servo::JointServo loop_;
  motion::JointEffort output_;

  void run(const takt::Cycle&) noexcept override {
    setpoint.read();
    measured.read();
    if (!setpoint.has_value() || !measured.has_value()) return;
    const motion::JointState& wanted = setpoint.value();
    const motion::JointState& is = measured.value();
    for (std::size_t i = 0; i < servo::kAxes; ++i) {
      if (std::abs(wanted.position()[i] - is.position()[i]) <= following) continue;
      fail("an axis does not follow its set point");
      break;
    }
    loop_ = {.stiffness = stiffness, .damping = damping, .limit = limit};
    output_.torque() = loop_.torque(wanted.position(), wanted.velocity(), is.position(), is.velocity());
    effort.write(output_);
  }
};
TAKT_COMPONENT(Servo)
