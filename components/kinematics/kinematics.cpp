// A thread module in C++: where the tool of an arm of six axes is.
#include <takt/component.hpp>

#include <optional>
#include <string>
#include <variant>

#include <motion.hpp>

#include "arm_model/kinematics.hpp"

class KinematicsModule : public takt::Component {
  takt::InPort<motion::JointState> joints{*this, "joints", {.text = "Where the axes are."}};
  takt::OutPort<motion::Pose> pose{*this, "pose", {.text = "Where the tool is then, in the foot."}};
  takt::Property<std::string> model{
      *this, "model", "", {.text = "File of the arm's parameters; empty: the arm that is built in."}};

  std::optional<arm_model::Kinematics> kinematics_;
  motion::Pose output_;

  takt::Result<void> initialize() override {
    auto read = arm_model::read(model);
    if (const auto* problem = std::get_if<std::string>(&read))
      return takt::fail(*problem, "name another file in the property 'model', or mend this one");
    kinematics_.emplace(std::get<arm_model::Parameters>(read));
    return {};
  }

  void run(const takt::Cycle&) noexcept override {
    if (!joints.read()) return;
    const arm_model::Pose at = arm_model::pose(kinematics_->forward(joints.value().position()));
    output_.x(at.x);
    output_.y(at.y);
    output_.z(at.z);
    output_.roll(at.roll);
    output_.pitch(at.pitch);
    output_.yaw(at.yaw);
    pose.write(output_);
  }
};
TAKT_COMPONENT(KinematicsModule, "Where the tool of a six-axis arm is.")
