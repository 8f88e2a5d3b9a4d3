// Names of ports, and patterns for these names. In a pattern, * stands for any characters: "line.*",
// "*.command".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::client {

inline bool is_pattern(std::string_view name) { return name.find('*') != std::string_view::npos; }

/// Whether `name` matches `pattern`. Each * stands for any number of characters, including none.
bool matches(std::string_view pattern, std::string_view name);

/// Whether a port of this device could match.
bool may_match(std::string_view pattern, std::string_view device);

struct PortName {
  std::string device;
  std::string module;
  std::string port;
};
/// Parses "device.module.port".
Result<PortName> parse_port(const std::string& name);

/// Fails if `names` is empty. Also fails with a problem for each name that is neither a port's name nor a
/// pattern.
Result<void> check_ports(const std::vector<std::string>& names);

}  // namespace takt::client
