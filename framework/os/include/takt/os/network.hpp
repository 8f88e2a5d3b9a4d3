// This machine's place on the network.
#pragma once

#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::os {

/// The IPv4 addresses of the interfaces that are up and have a cable, in the system's order: "127.0.0.1",
/// "10.0.0.7". Fails where the system does not say, as when this process has no descriptor left.
Result<std::vector<std::string>> ipv4_addresses();

/// The IPv4 address of a host's name, or of an address itself. May wait for the name service. Fails where
/// there is none.
Result<std::string> resolve_ipv4(const std::string& host);

}  // namespace takt::os
