// A thread module in C++: simulates the joints of a six-axis arm.
#include <takt/component.hpp>

#include <motion.hpp>

#include "joints.hpp"

class Arm : public takt::Component {
  takt::InPort<motion::JointEffort> effort{*this, "effort", {.text = "What the drives give."}};
  takt::OutPort<motion::JointState> measured{*this, "measured", {.text = "Where the axes are."}};
  takt::Property<double> friction{
      *this, "friction", 20, {.unit = "N m s/rad", .min = 0, .max = 10000, .text = "Of every joint."}};

  arm::JointModel joints_;
  motion::JointState state_;

  void run(const takt::Cycle& cycle) noexcept override {
    joints_.friction = friction;
    effort.read();
    joints_.step(effort.value().torque(), cycle.seconds());
    state_.position() = joints_.position;
    state_.velocity() = joints_.velocity;
    measured.write(state_);
  }
};
TAKT_COMPONENT(Arm)
