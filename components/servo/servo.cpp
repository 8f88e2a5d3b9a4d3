// A thread module in C++: the position loop of a six-axis arm.
#include <takt/component.hpp>

#include <cmath>
#include <optional>
#include <string>
#include <variant>

#include <motion.hpp>

#include "joint_servo.hpp"

class Servo : public takt::Component {
  takt::InPort<motion::JointState> setpoint{*this, "setpoint", {.text = "Set points of the axes."}};
  takt::InPort<motion::JointState> measured{
      *this, "measured", {.text = "Measured position and velocity of the axes."}};
  takt::OutPort<motion::JointEffort> effort{*this, "effort", {.text = "Torques for the drives."}};
  takt::Property<std::string> model{
      *this, "model", "", {.text = "File with the arm's parameters; empty: the built-in arm."}};
  takt::Property<double> bandwidth{
      *this,
      "bandwidth",
      15,
      {.unit = "Hz", .min = 0.1, .max = 40, .text = "Bandwidth of the position loop."}};
  takt::Property<double> damping{
      *this,
      "damping",
      1,
      {.min = 0.1, .max = 2, .text = "Damping ratio of the position loop; 1: no overshoot."}};
  takt::Property<bool> gravity{*this, "gravity", true, {.text = "Feed forward the weight of the links."}};
  takt::Property<bool> acceleration{
      *this,
      "acceleration",
      true,
      {.text = "Feed forward the acceleration of the set points, and the friction."}};
  takt::Property<double> following{
      *this,
      "following",
      0.1,
      {.unit = "rad",
       .min = 0.001,
       .max = 3,
       .text = "Maximum following error of an axis; beyond it, the module goes to RECOVER."}};

  std::optional<servo::JointServo> loop_;
  servo::Motion wanted_;
  bool had_one_ = false;
  motion::JointEffort output_;

  takt::Result<void> initialize() override {
    auto read = arm_model::read(model);
    if (const auto* problem = std::get_if<std::string>(&read))
      return takt::fail(*problem, "correct the file, or set property 'model' to another file");
    loop_.emplace(std::get<arm_model::Parameters>(read));
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    setpoint.read();
    measured.read();
    if (!setpoint.has_value() || !measured.has_value()) return;
    const servo::Motion wanted{setpoint.value().position(), setpoint.value().velocity()};
    const servo::Motion is{measured.value().position(), measured.value().velocity()};
    for (std::size_t i = 0; i < arm_model::kAxes; ++i) {
      if (std::abs(wanted.position[i] - is.position[i]) <= following) continue;
      had_one_ = false;
      return fail("an axis does not follow its set point");
    }
    loop_->bandwidth = bandwidth;
    loop_->damping = damping;
    loop_->gravity = gravity;
    loop_->acceleration = acceleration;
    output_.torque() = loop_->torque(wanted, had_one_ ? wanted_ : wanted, is, cycle.seconds());
    wanted_ = wanted;
    had_one_ = true;
    effort.write(output_);
  }
};
TAKT_COMPONENT(Servo, "Position loop of a six-axis arm.")
