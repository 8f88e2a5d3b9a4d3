// Asks a device to publish the samples of a port for an observer.
#pragma once

#include <chrono>
#include <string>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/gateway.hpp>

namespace takt::client {

/// How long a device publishes the samples of a port after each request.
inline constexpr std::chrono::seconds kTapped{30};
/// How often to repeat the request, so that the device does not stop publishing.
inline constexpr std::chrono::seconds kAskAgain{10};

/// Asks the device of `port`, "device.module.port", to publish this port. Returns the topic and type of the
/// samples. Fails if the port does not exist or is a service: the requests and replies of a service are
/// published as ports of its client.
Result<dds::Flow> tapped(Operator& asker, const std::string& port);

}  // namespace takt::client
