// A thread module in C++: publishes an arm's axis positions for ROS 2, as sensor_msgs/JointState.
#include <takt/component.hpp>

#include <chrono>

#include <motion.hpp>
#include <sensor_msgs.hpp>

#include "names.hpp"

class JointStates : public takt::Component {
  takt::InPort<motion::JointState> measured{
      *this, "measured", {.text = "Position and velocity of the axes."}};
  takt::OutPort<sensor_msgs::msg::JointState> joint_states{
      *this, "joint_states", {.text = "The measured positions as a ROS 2 message, for a ROS 2 topic."}};
  takt::Property<std::string> names{
      *this,
      "names",
      "joint1 joint2 joint3 joint4 joint5 joint6",
      {.text = "Axis names in ROS 2, as in the URDF: six names separated by spaces."}};
  takt::Property<std::string> frame{*this, "frame", "base_link", {.text = "Frame in the message header."}};

  sensor_msgs::msg::JointState message_;

  takt::Result<void> initialize() override {
    const auto words = joint_states::words(names.value());
    if (words.size() != motion::AXES) {
      return takt::fail("'names' has " + std::to_string(words.size()) + " names",
                        "write six names separated by spaces, one for each axis");
    }
    for (const std::string& word : words) {
      if (word.size() > joint_states::kLongest)
        return takt::fail("the name '" + word + "' is too long", "use at most 63 characters");
    }
    if (frame.value().size() > joint_states::kLongest)
      return takt::fail("'frame' is too long", "use at most 63 characters");
    message_.name().assign(words.begin(), words.end());
    message_.header().frame_id(frame.value());
    message_.position().resize(motion::AXES);
    message_.velocity().resize(motion::AXES);
    return {};
  }

  void run(const takt::Cycle&) noexcept override {
    if (!measured.read()) return;
    // ROS 2 expects wall-clock time. Reading the clock makes no system call.
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
    message_.header().stamp().sec(static_cast<std::int32_t>(seconds.count()));
    message_.header().stamp().nanosec(
        static_cast<std::uint32_t>(std::chrono::nanoseconds{now - seconds}.count()));
    const motion::JointState& is = measured.value();
    for (std::size_t i = 0; i < motion::AXES; ++i) {
      message_.position()[i] = is.position()[i];
      message_.velocity()[i] = is.velocity()[i];
    }
    joint_states.write(message_);
  }
};
TAKT_COMPONENT(JointStates, "Publishes an arm's axis positions for ROS 2 programs.")
