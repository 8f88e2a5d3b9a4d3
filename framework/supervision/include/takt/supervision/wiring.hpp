// The wiring of a device's ports: its links, the writer and reader of each, and the topics to ports of other
// devices.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/channel/shared.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/hosts.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/flow_health.hpp>

namespace takt::supervision {

/// A side of a link: a port of one of the device's modules, or the gateway.
struct LinkEnd {
  std::optional<std::uint32_t> module;  ///< its index on the device; none for the gateway
  std::string port{};                   ///< the module's port; empty for the gateway
  bool operator==(const LinkEnd&) const = default;
};

struct PlannedLink {
  LinkEnd from{};
  LinkEnd to{};
  /// Whether both ends are C++ modules of the shared host. If so, the samples are values in the host's
  /// memory; otherwise they are bytes in the link's memory.
  bool typed = false;
  channel::Link::Options options{};
  model::Stale stale =
      model::Stale::hold;  ///< what the reader does when a value is older than options.deadline_ns
  /// The output that writes to this link, if the reader gets a safe value while the writing module does not
  /// execute. Otherwise this is not given.
  model::Endpoint writer{};
  std::vector<std::byte> safe{};  ///< the safe value, if known; that of another device's output arrives later
};

/// A topic that the gateway moves samples to or from.
struct PlannedFlow {
  bool outgoing = true;
  std::string topic{};
  std::optional<int> domain{};  ///< none for the cell's domain
  model::Type type{};
  bool reliable = false;
  std::uint32_t depth = 1;
  std::optional<Nanoseconds> deadline{};
  std::optional<Nanoseconds> lifespan{};
  /// Requests are sent only while a service can answer. Replies are kept for a client that the service has
  /// not matched yet, although the client has already matched the service and sent a request.
  model::Carries carries = model::Carries::samples;
  /// Whether a connection uses this flow. An output without a connection also has a flow, for `takt echo`;
  /// its link is not enabled.
  bool connected = false;
  std::vector<std::size_t> links{};  ///< indices in WiringPlan::links: one outgoing, or all incoming
};

struct WiringPlan {
  std::vector<PlannedLink> links;
  std::vector<PlannedFlow> flows;
};

/// Plans the links and flows of a device, without side effects. `ports` are those of the device's modules;
/// the connections must have been checked against them. A module whose ports are not known gets no links.
WiringPlan plan_wiring(const model::Cell& cell, std::size_t device,
                       const std::vector<model::ModulePorts>& ports);

/// The topic of a port: takt/<cell>/<device>/<module>/<port>.
std::string port_topic(const std::string& cell, const model::Endpoint& port);

/// The health of a port, for an operator.
struct PortHealth {
  std::uint32_t connections = 0;  ///< connections in the descriptor, without observers and calls from outside
  std::uint32_t matched = 0;      ///< connections whose other end is there
  std::uint64_t samples = 0;      ///< written (output) or taken (input)
  std::uint64_t lost = 0;         ///< samples lost between devices
  std::uint64_t dropped = 0;      ///< samples dropped from full queues
  std::uint64_t refused = 0;      ///< samples rejected because they do not fit the port's type
  std::uint64_t late = 0;         ///< how often a value became older than its connection's deadline
  bool safe = false;              ///< whether the reader of this input gets the safe value now
  std::int64_t age_ns = -1;       ///< age of the newest value; -1 if there is none
  std::string incompatible{};     ///< the QoS policy that prevented a match; empty if there is none
};

/// The links of a device, in shared memory. They live as long as this object, across restarts of the host and
/// of programs.
class Wiring {
 public:
  struct Wire {
    PlannedLink plan;
    channel::Shared<std::byte> memory;
    channel::Link link;
    bool late = false;      ///< whether its value was older than its deadline at the last check
    bool connected = true;  ///< whether a connection of the descriptor uses it
  };

  static Result<Wiring> create(WiringPlan plan);

  [[nodiscard]] const std::vector<Wire>& wires() const noexcept { return wires_; }
  /// The wires that a module reads and that have a deadline.
  [[nodiscard]] std::vector<Wire*> with_deadline(std::uint32_t module);
  [[nodiscard]] const std::vector<PlannedFlow>& flows() const noexcept { return flows_; }

  /// Sets the safe value of an output of another device.
  void give_safe(const model::SafeOutput& output);

  /// The health of a port at `now_ns` (monotonic clock), from the links and, for links with a flow, from
  /// `on_dds`, which receives the index of the wire and returns nothing if the flow is not open.
  using OnDds = std::function<std::optional<wire::FlowHealth>(std::size_t wire)>;
  [[nodiscard]] PortHealth health(std::uint32_t module, const model::Port& port, std::int64_t now_ns,
                                  const OnDds& on_dds) const;

  /// The outgoing flow of a port; null if the module has no such output.
  [[nodiscard]] const PlannedFlow* flow_of(std::uint32_t module, const std::string& port) const;

 private:
  std::vector<Wire> wires_;
  std::vector<PlannedFlow> flows_;
};

}  // namespace takt::supervision
