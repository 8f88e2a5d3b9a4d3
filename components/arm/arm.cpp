// A thread module in C++: simulates a six-axis arm as rigid bodies.
#include <takt/component.hpp>

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <variant>

#include <motion.hpp>

#include "rigid_arm.hpp"

class Arm : public takt::Component {
  takt::InPort<motion::JointEffort> effort{*this, "effort", {.text = "Torques of the drives."}};
  takt::OutPort<motion::JointState> measured{
      *this, "measured", {.text = "Position and velocity of the axes."}};
  takt::Property<std::string> model{
      *this, "model", "", {.text = "File with the arm's parameters; empty: the built-in arm."}};
  takt::Property<double> friction{
      *this, "friction", 1, {.min = 0, .max = 1, .text = "Fraction of the model's friction to apply."}};
  takt::Property<double> brake{
      *this,
      "brake",
      0.02,
      {.unit = "s", .min = 0.001, .max = 10, .text = "The brakes close if no effort arrives for this long."}};

  std::optional<arm::RigidArm> arm_;
  motion::JointState state_;

  takt::Result<void> initialize() override {
    auto read = arm_model::read(model);
    if (const auto* problem = std::get_if<std::string>(&read))
      return takt::fail(*problem, "correct the file, or set property 'model' to another file");
    const auto& parameters = std::get<arm_model::Parameters>(read);
    if (const std::size_t stiff = arm::RigidArm::too_stiff(parameters); stiff < arm_model::kAxes)
      return takt::fail("axes[" + std::to_string(stiff) + "] has too much friction to simulate",
                        "change the file so that viscous + 20 * dry is below 1500 * rotor");
    arm_.emplace(parameters);
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    arm_->friction = friction;
    effort.read();
    if (!effort.has_value() || effort.age() > std::chrono::duration<double>{brake.value()}) {
      arm_->brake(cycle.seconds());
    } else {
      for (const double torque : effort.value().torque())
        if (!std::isfinite(torque)) return fail("an effort is not a finite number");
      arm_->step(effort.value().torque(), cycle.seconds());
    }
    state_.position() = arm_->position;
    state_.velocity() = arm_->velocity;
    measured.write(state_);
  }
};
TAKT_COMPONENT(Arm, "Simulates the rigid bodies of a six-axis arm.")
