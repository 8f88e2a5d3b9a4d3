// Names in one text with spaces between them.
#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

namespace joint_states {

inline constexpr std::size_t kLongest = 63;  ///< of a name in sensor_msgs/JointState as idl/ros2 has it

inline std::vector<std::string> words(const std::string& text) {
  std::istringstream stream{text};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace joint_states
