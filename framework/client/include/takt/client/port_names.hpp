// Names of ports with * for any characters: "line.*", "robot.arm.*", "*.command".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::client {

inline bool is_pattern(std::string_view name) { return name.find('*') != std::string_view::npos; }

/// Whether a * stands for what is missing, from none to all of it.
bool matches(std::string_view pattern, std::string_view name);

/// Whether a port of this device could match.
bool may_match(std::string_view pattern, std::string_view device);

struct PortName {
  std::string device;
  std::string module;
  std::string port;
};
/// "device.module.port".
Result<PortName> parse_port(const std::string& name);

/// What is none of them, each said.
Result<void> check_ports(const std::vector<std::string>& names);

}  // namespace takt::client
