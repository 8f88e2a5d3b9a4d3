// A port whose samples somebody wants to see.
#pragma once

#include <chrono>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/gateway.hpp>

namespace takt::client {

/// So long a port is published for who asked; ask again before.
inline constexpr std::chrono::seconds kTapped{30};
inline constexpr std::chrono::seconds kAskAgain{10};

/// Asks the device of "device.module.port" to publish it. Fails where there is no such port, and where it is
/// a service: that has a request and a reply, each a port of its client.
Result<dds::Flow> tapped(Operator& asker, const std::string& port);

}  // namespace takt::client
