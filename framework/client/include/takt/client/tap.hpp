// Asks a device to publish the samples of a port for an observer.
#pragma once

#include <chrono>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/gateway.hpp>

namespace takt::client {

/// How long a device publishes a port after it was asked to.
inline constexpr std::chrono::seconds kTapped{30};
/// How often to ask again, so that the samples do not stop.
inline constexpr std::chrono::seconds kAskAgain{10};

/// Asks the device of "device.module.port" to publish it. Fails if there is no such port, or if it is a
/// service: its requests and replies are ports of its client.
Result<dds::Flow> tapped(Operator& asker, const std::string& port);

}  // namespace takt::client
