// A thread module in C++: the set points of a six-axis arm that takes parts off a belt when it is asked to.
#include <takt/component.hpp>

#include <motion.hpp>

#include "path.hpp"

class Trajectory : public takt::Component {
  takt::InPort<motion::PickRequest> request{*this, "request", {.text = "Parts to be taken away, in turn."}};
  takt::OutPort<motion::JointState> setpoint{*this, "setpoint", {.text = "Where the axes are to be."}};
  takt::OutPort<motion::PickDone> done{*this, "done", {.text = "A part was put on the pallet."}};
  takt::Property<double> leg{
      *this,
      "leg",
      0.4,
      {.unit = "s", .min = 0.05, .max = 10, .text = "Each of the five legs of a cycle takes this."}};

  trajectory::Path path_;
  motion::JointState state_;
  motion::PickDone report_;  // of the last part
  double asked_ = 0;         // s since the request

  void run(const takt::Cycle& cycle) noexcept override {
    if (!path_.busy() && request.read()) take_on(request.value());
    asked_ += cycle.seconds();
    const trajectory::Point point = path_.step(cycle.seconds());
    state_.position() = point.position;
    state_.velocity() = point.velocity;
    setpoint.write(state_);
    if (path_.put_down()) {
      report_.duration(asked_);
      done.write(report_);
    }
  }

  // Who asks for a part again has not heard that it is done: the network was down.
  void take_on(const motion::PickRequest& part) noexcept {
    if (part.number() == report_.number()) {
      done.write(report_);
      return;
    }
    path_.begin(part.offset(), leg);
    report_.number(part.number());
    asked_ = 0;
  }
};
TAKT_COMPONENT(Trajectory)
