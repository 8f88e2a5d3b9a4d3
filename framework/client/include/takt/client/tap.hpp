// Asks a device to publish the samples of a port for an observer, or to open a service for a caller.
#pragma once

#include <chrono>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/client/port_names.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/type.hpp>

namespace takt::client {

/// The time for which a device publishes the samples of a port after each request.
inline constexpr std::chrono::seconds kTapped{30};
/// The time after which the program repeats the request, so that the device does not stop publishing.
inline constexpr std::chrono::seconds kAskAgain{10};

/// Asks the device of `port`, "device.module.port", to publish the samples of this port. Returns the topic
/// and type of the samples. Fails if the port does not exist or belongs to a service. To observe a service,
/// use the ports of its client. `every`: the device may publish only the newest sample, once in this time; 0:
/// every sample. A port that is connected to another device always has every sample.
Result<dds::Flow> tapped(Operator& sender, const std::string& port, Nanoseconds every = {});
/// The request that tapped() sends, for a program that sends several at once and passes the data of each
/// answer to flow_in().
Result<CommandRequest> tap_request(const std::string& port, Nanoseconds every = {});

/// Returns the topic and type that the node's answer `data` names. Fails if `data` is not such an answer,
/// which any program on the network may have sent, or if the port belongs to a service.
Result<dds::Flow> flow_in(const std::string& data, const std::string& port);

/// The request topic and the reply topic of a service, with their types.
struct ServiceTopics {
  std::string request_topic;
  std::string reply_topic;
  model::Type request;
  model::Type reply;
};

/// Asks the device of a service to open the service for this time to programs outside the cell. If the module
/// has no such service, the problem says whether a port has this name, and lists the services that exist. If
/// `name.port` is empty, the problem only lists the services.
Result<ServiceTopics> opened_service(Operator& sender, const PortName& name, Nanoseconds open_for);

/// Parts of opened_service() that need no network.
/// Returns the topics and types that the node's answer `data` names; none if the name is a port. Fails if
/// `data` is not such an answer.
Result<std::optional<ServiceTopics>> service_in(const std::string& data, const PortName& name);
/// Returns the problem that the name is a port, or that the module has no port or service of this name; none
/// if the name is a service or a client. `name.port` may be empty. `others` are the names of the services of
/// the other modules of the device; the problem lists them if the module has no services.
std::optional<Problem> not_a_service(const PortName& name, const std::vector<model::Port>& ports,
                                     const std::set<std::string>& others = {});

}  // namespace takt::client
