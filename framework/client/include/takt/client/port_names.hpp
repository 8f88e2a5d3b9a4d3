// Names of ports, and patterns of them in which * stands for any characters: "line.*", "*.command".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::client {

inline bool is_pattern(std::string_view name) { return name.find('*') != std::string_view::npos; }

/// Whether `name` matches `pattern`; each * stands for any number of characters, also none.
bool matches(std::string_view pattern, std::string_view name);

/// Whether some port of this device could match.
bool may_match(std::string_view pattern, std::string_view device);

struct PortName {
  std::string device;
  std::string module;
  std::string port;
};
/// Parses "device.module.port".
Result<PortName> parse_port(const std::string& name);

/// Fails if there is no name, and with a problem for each that is neither a port's name nor a pattern.
Result<void> check_ports(const std::vector<std::string>& names);

}  // namespace takt::client
