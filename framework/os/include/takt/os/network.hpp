// The network addresses of this machine, and name lookup.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::os {

/// Returns the IPv4 addresses of the network interfaces that are up and connected, in the system's order, for
/// example "127.0.0.1" and "10.0.0.7". Fails if a system call fails, for example because this process cannot
/// open another file descriptor.
Result<std::vector<std::string>> ipv4_addresses();

/// Converts a host name or an address to an IPv4 address. May wait for the name service. Fails if the host
/// name has no IPv4 address.
Result<std::string> resolve_ipv4(const std::string& host);

}  // namespace takt::os
