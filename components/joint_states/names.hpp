// Splits a text into names at white space.
#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <vector>

namespace joint_states {

/// Maximum length of a name in sensor_msgs/JointState of idl/ros2.
inline constexpr std::size_t kLongest = 63;

inline std::vector<std::string> words(const std::string& text) {
  std::istringstream stream{text};
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace joint_states
