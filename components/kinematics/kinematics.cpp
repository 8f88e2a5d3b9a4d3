// A thread module in C++: computes the pose of a six-axis arm's tool.
#include <takt/component.hpp>

#include <optional>
#include <string>
#include <variant>

#include <motion.hpp>

#include "arm_model/kinematics.hpp"

class KinematicsModule : public takt::Component {
  takt::InPort<motion::JointState> joints{*this, "joints", {.text = "Position of the axes."}};
  takt::OutPort<motion::Pose> pose{
      *this, "pose", {.text = "Pose of the tool in the frame of the robot's foot."}};
  takt::Property<std::string> model{
      *this, "model", "", {.text = "File with the arm's parameters; empty: the built-in arm."}};

  std::optional<arm_model::Kinematics> kinematics_;
  motion::Pose output_;

  takt::Result<void> initialize() override {
    auto read = arm_model::read(model);
    if (const auto* problem = std::get_if<std::string>(&read))
      return takt::fail(*problem, "correct the file, or set property 'model' to another file");
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
TAKT_COMPONENT(KinematicsModule, "Computes the pose of a six-axis arm's tool.")
