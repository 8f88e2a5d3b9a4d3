// A thread module in C++: simulates an arm of six axes as rigid bodies.
#include <takt/component.hpp>

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <variant>

#include <motion.hpp>

#include "rigid_arm.hpp"

class Arm : public takt::Component {
  takt::InPort<motion::JointEffort> effort{*this, "effort", {.text = "What the drives give."}};
  takt::OutPort<motion::JointState> measured{*this, "measured", {.text = "Where the axes are."}};
  takt::Property<std::string> model{
      *this, "model", "", {.text = "File of the arm's parameters; empty: the arm that is built in."}};
  takt::Property<double> friction{
      *this, "friction", 1, {.min = 0, .max = 1, .text = "Share of the parameters' friction that there is."}};
  takt::Property<double> brake{
      *this,
      "brake",
      0.02,
      {.unit = "s", .min = 0.001, .max = 10, .text = "The brakes close when no effort came for this long."}};

  std::optional<arm::RigidArm> arm_;
  motion::JointState state_;

  takt::Result<void> initialize() override {
    auto read = arm_model::read(model);
    if (const auto* problem = std::get_if<std::string>(&read))
      return takt::fail(*problem, "name another file in the property 'model', or mend this one");
    const auto& parameters = std::get<arm_model::Parameters>(read);
    if (const std::size_t stiff = arm::RigidArm::too_stiff(parameters); stiff < arm_model::kAxes)
      return takt::fail("axes[" + std::to_string(stiff) + "] has more friction than can be simulated",
                        "viscous + 20 dry must be below 1500 rotor");
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
        if (!std::isfinite(torque)) return fail("an effort is not a number");
      arm_->step(effort.value().torque(), cycle.seconds());
    }
    state_.position() = arm_->position;
    state_.velocity() = arm_->velocity;
    measured.write(state_);
  }
};
TAKT_COMPONENT(Arm, "Rigid bodies of a six-axis arm, simulated.")
