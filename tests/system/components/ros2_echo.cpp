// Exchanges messages with a ROS 2 program: returns each text in capital letters, and the x component of each
// velocity as a number.
#include <takt/component.hpp>

#include <algorithm>
#include <array>
#include <cctype>

#include <geometry_msgs.hpp>
#include <std_msgs.hpp>

class Ros2Echo : public takt::Component {
  takt::InPort<std_msgs::msg::String> text{*this, "text"};
  takt::InPort<geometry_msgs::msg::Twist> velocity{*this, "velocity"};
  takt::OutPort<std_msgs::msg::String> capitals{*this, "capitals"};
  takt::OutPort<std_msgs::msg::Float64> x{*this, "x"};

  std_msgs::msg::String answer_;
  std_msgs::msg::Float64 number_;

  void run(const takt::Cycle&) noexcept override {
    while (text.read()) {
      std::array<char, 256> letters{};
      const auto& given = text.value().data();
      std::transform(given.c_str(), given.c_str() + given.size(), letters.begin(),
                     [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
      answer_.data() = letters.data();
      capitals.write(answer_);
    }
    if (velocity.read()) {
      number_.data(velocity.value().linear().x());
      x.write(number_);
    }
  }
};
TAKT_COMPONENT(Ros2Echo)
