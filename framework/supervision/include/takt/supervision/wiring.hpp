// The wiring of a device's ports: the links, the writer and the reader of each link, and the topics that
// connect ports to other devices.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
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

/// The largest value in bytes that an input can be forced to. It is small, because each link to an input that
/// can be forced reserves this memory.
inline constexpr std::uint32_t kMostForced = 4096;

/// A side of a link: a port of one of the device's modules, or the gateway.
struct LinkEnd {
  std::optional<std::uint32_t> module;  ///< index of the module on the device; empty for the gateway
  std::string port{};                   ///< the module's port; empty for the gateway
  bool operator==(const LinkEnd&) const = default;
};

struct PlannedLink {
  LinkEnd from{};
  LinkEnd to{};
  /// True if both ends are C++ modules of the shared host. Then the samples are C++ objects in the host's
  /// memory; otherwise they are bytes in the link's memory.
  bool typed = false;
  channel::Link::Options options{};
  model::Stale stale =
      model::Stale::hold;  ///< the reaction of the reader to a value that is older than options.deadline_ns
  /// The other device whose samples the gateway writes to this link; empty if the samples come from this
  /// device or from outside the cell.
  std::string sender{};
  /// The number of connections of the descriptor that use the link, by the device at the other end; the name
  /// is empty for programs outside the cell. Only a link from an output to the gateway has more than one
  /// connection. A link for observers, or for calls from outside the cell, has none.
  std::map<std::string, std::uint32_t> connections{};
  /// The output that writes to this link, if the reader gets a safe value while the writing module does not
  /// execute. Otherwise empty.
  model::Endpoint writer{};
  std::vector<std::byte> safe{};  ///< the safe value; empty while it is not known, as for an output of
                                  ///< another device
};

/// A topic to which or from which the gateway moves samples.
struct PlannedFlow {
  bool outgoing = true;
  std::string topic{};
  std::optional<int> domain{};  ///< empty for the cell's domain
  model::Type type{};
  bool reliable = false;
  std::uint32_t depth = 1;
  std::optional<Nanoseconds> deadline{};
  std::optional<Nanoseconds> lifespan{};
  /// The kind of data that the flow carries. Requests are sent only while a service can answer. A client may
  /// match the service, and send a request, before the service matches the client. So a reply is kept until
  /// the service has matched the client.
  model::Carries carries = model::Carries::samples;
  /// True if a connection uses this flow. An output without a connection also has a flow, for `takt echo`;
  /// the link of this flow is not enabled.
  bool connected = false;
  std::vector<std::size_t> links{};  ///< indices in WiringPlan::links: one link if the flow is outgoing, one
                                     ///< or more if it is incoming
  /// The devices of the cell that have the other end of a connection, each with its first connection, such as
  /// "robot.arm.measured -> station.panel.arm". Without the programs outside the cell.
  std::map<std::string, std::string> ends{};
};

struct WiringPlan {
  std::vector<PlannedLink> links;
  std::vector<PlannedFlow> flows;
};

/// Plans the links and flows of a device, without side effects. `ports` are the ports of the device's
/// modules; the connections must already have been checked against these ports. A module whose ports are not
/// known gets no links.
WiringPlan plan_wiring(const model::Cell& cell, std::size_t device,
                       const std::vector<model::ModulePorts>& ports);

/// The topic of a port: takt/<cell>/<device>/<module>/<port>.
std::string port_topic(const std::string& cell, const model::Endpoint& port);

/// The health of a port, for an operator.
struct PortHealth {
  std::uint32_t connections = 0;  ///< connections in the descriptor; observers and calls from outside the
                                  ///< cell do not count
  std::uint32_t matched = 0;      ///< connections whose other end is available
  std::uint64_t samples = 0;      ///< samples that the output has written, or that the input has taken
  std::uint64_t lost = 0;         ///< samples lost between devices
  std::uint64_t dropped = 0;      ///< samples dropped from the full queues of connections
  std::uint64_t refused = 0;      ///< samples rejected because they do not fit the port's type
  /// Samples whose time stamp cannot be right, so their age is measured from their arrival.
  std::uint64_t untimed = 0;
  std::uint64_t late = 0;  ///< number of times that the newest value became older than its
                           ///< connection's deadline
  bool safe = false;       ///< true if the reader of this input gets the safe value now
  /// Connections whose other end belongs to the cell but is not available.
  std::uint32_t missing = 0;
  /// The shortest deadline of the input's connections; none for an output.
  std::optional<Nanoseconds> deadline{};
  bool losing = false;         ///< true if `lost` has risen recently
  bool dropping = false;       ///< true if a queue has dropped samples recently
  std::int64_t age_ns = -1;    ///< age of the newest value; -1 if there is none
  std::string incompatible{};  ///< the QoS policy that prevented a match; empty if there is none
  std::string forced{};        ///< who forces this input; empty if it is not forced
};

/// The links of a device, in shared memory. The links live as long as this object, even if the host and
/// programs restart.
class Wiring {
 public:
  struct CreatedLink {
    PlannedLink plan;
    channel::Shared<std::byte> memory;
    channel::Link link;
    bool late = false;  ///< whether the newest value was older than the link's deadline at the last check

    /// True if a connection of the descriptor uses the link.
    [[nodiscard]] bool connected() const noexcept { return !plan.connections.empty(); }
  };

  static Result<Wiring> create(WiringPlan plan);

  [[nodiscard]] const std::vector<CreatedLink>& links() const noexcept { return links_; }
  /// The links that a module reads and that have a deadline.
  [[nodiscard]] std::vector<CreatedLink*> with_deadline(std::uint32_t module);
  [[nodiscard]] const std::vector<PlannedFlow>& flows() const noexcept { return flows_; }

  /// Stores the safe value of an output of another device. Readers on this device get this value when the
  /// output is lost.
  void give_safe(const model::SafeOutput& output);

  /// A function that returns the health of the flow of the link with this index, or nothing if the flow is
  /// not open.
  using OnDds = std::function<std::optional<wire::FlowHealth>(std::size_t link)>;
  /// A function that returns true if another device is lost.
  using IsLost = std::function<bool(const std::string& device)>;
  /// Returns the health of a port at `now_ns` (monotonic clock), from its links and, for links with a flow,
  /// from `on_dds`. A connection to a lost device is not matched, although DDS keeps the match for some
  /// seconds. An empty `is_lost` means that no device is lost.
  [[nodiscard]] PortHealth health(std::uint32_t module, const model::Port& port, std::int64_t now_ns,
                                  const OnDds& on_dds, const IsLost& is_lost = {}) const;

  /// Returns a connection of the cell whose other end has not been found on DDS, or several if it can be each
  /// of them: "robot.arm.measured -> station.panel.arm". Empty if all other ends have been found.
  [[nodiscard]] std::string unmatched(const OnDds& on_dds) const;

  /// The outgoing flow of a port; null if the module has no such output.
  [[nodiscard]] const PlannedFlow* flow_of(std::uint32_t module, const std::string& port) const;

 private:
  std::vector<CreatedLink> links_;
  std::vector<PlannedFlow> flows_;
};

}  // namespace takt::supervision
