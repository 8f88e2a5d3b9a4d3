// Parses port names and matches them with patterns. In a pattern, * stands for any number of characters,
// including none: "line.*", "*.command".
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::client {

inline bool is_pattern(std::string_view name) { return name.find('*') != std::string_view::npos; }

/// Returns true if `name` matches `pattern`. Each * matches any number of characters, including none.
bool matches(std::string_view pattern, std::string_view name);

/// Returns true if `pattern` could match the name of a port of this device.
bool may_match(std::string_view pattern, std::string_view device);

struct PortName {
  std::string device;
  std::string module;
  std::string port;
};
/// Parses "device.module.port".
Result<PortName> parse_port(const std::string& name);

/// Checks port names and patterns. Fails if `names` is empty, and with one problem for each name that is
/// neither a port name nor a pattern.
Result<void> check_ports(const std::vector<std::string>& names);

}  // namespace takt::client
