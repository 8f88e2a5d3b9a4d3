// Asks a device to publish the samples of a port for an observer.
#pragma once

#include <chrono>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/gateway.hpp>

namespace takt::client {

/// How long a device publishes a port after a request.
inline constexpr std::chrono::seconds kTapped{30};
/// How often to repeat the request, so that the samples do not stop.
inline constexpr std::chrono::seconds kAskAgain{10};

/// Asks the device of `port`, "device.module.port", to publish this port. Fails if the port does not exist or
/// is a service. The requests and replies of a service are ports of its client.
Result<dds::Flow> tapped(Operator& asker, const std::string& port);

}  // namespace takt::client
