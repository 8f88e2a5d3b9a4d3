// A thread module in C++: says to programs of ROS 2 where an arm's axes are, as sensor_msgs/JointState.
#include <takt/component.hpp>

#include <chrono>

#include <motion.hpp>
#include <sensor_msgs.hpp>

#include "names.hpp"

class JointStates : public takt::Component {
  takt::InPort<motion::JointState> measured{*this, "measured", {.text = "Where the axes are."}};
  takt::OutPort<sensor_msgs::msg::JointState> joint_states{
      *this, "joint_states", {.text = "The same, for a topic of ROS 2."}};
  takt::Property<std::string> names{
      *this,
      "names",
      "joint1 joint2 joint3 joint4 joint5 joint6",
      {.text = "What ROS 2 calls the axes, as in its URDF: six names with spaces between them."}};
  takt::Property<std::string> frame{*this, "frame", "base_link", {.text = "The frame of the header."}};

  sensor_msgs::msg::JointState message_;

  takt::Result<void> initialize() override {
    const auto words = joint_states::words(names.value());
    if (words.size() != motion::AXES) {
      return takt::fail("'names' has " + std::to_string(words.size()) + " names",
                        "an arm has six axes: write six names with spaces between them");
    }
    for (const std::string& word : words) {
      if (word.size() > joint_states::kLongest)
        return takt::fail("the name '" + word + "' is too long", "a name has at most 63 characters");
    }
    if (frame.value().size() > joint_states::kLongest)
      return takt::fail("'frame' is too long", "a frame has at most 63 characters");
    message_.name().assign(words.begin(), words.end());
    message_.header().frame_id(frame.value());
    message_.position().resize(motion::AXES);
    message_.velocity().resize(motion::AXES);
    return {};
  }

  void run(const takt::Cycle&) noexcept override {
    if (!measured.read()) return;
    // Wall-clock time, as ROS 2 stamps; read without a system call.
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
TAKT_COMPONENT(JointStates, "Says an arm's axes to programs of ROS 2.")
