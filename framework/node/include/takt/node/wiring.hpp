// How the ports of a device are connected: which links there are, who writes and who reads each, and over
// which topics they go on where the other end is not on this device.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/host/protocol.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/hosts.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::node {

/// A side of a link: a port of one of the device's modules, or the gateway.
struct LinkEnd {
  std::optional<std::uint32_t> module;  ///< its index on the device; none: the gateway
  std::string port{};                   ///< of the module
  bool operator==(const LinkEnd&) const = default;
};

struct PlannedLink {
  LinkEnd from{};
  LinkEnd to{};
  /// Both ends are C++ modules of one host: the samples are values in its memory. Otherwise they are bytes in
  /// the link's.
  bool typed = false;
  channel::Link::Options options{};
  model::Stale stale =
      model::Stale::hold;  ///< what the reader does when a value is older than options.deadline_ns
  /// Whose output it is, where its reader gets a safe value while that module does not execute; not given: it
  /// gets none.
  model::Endpoint writer{};
  std::vector<std::byte> safe{};  ///< the value, as far as it is known here: not of another device's
};

/// A topic that the gateway moves samples to or from.
struct PlannedFlow {
  bool outgoing = true;
  std::string topic{};
  std::optional<int> domain{};  ///< none: the cell's
  model::Type type{};
  bool reliable = false;
  std::uint32_t depth = 1;
  std::optional<Nanoseconds> deadline{};
  std::optional<Nanoseconds> lifespan{};
  /// Requests go out while somebody is there to answer. Replies are kept for a reader that their writer does
  /// not know yet: he has found the writer of requests, and asked.
  model::Carries carries = model::Carries::samples;
  /// Somebody is meant to be at the other end: a connection names it. An output without one has a flow too,
  /// for `takt echo`, whose link is not enabled.
  bool connected = false;
  std::vector<std::size_t> links{};  ///< in WiringPlan::links: one that goes out, or all that come in
};

struct WiringPlan {
  std::vector<PlannedLink> links;
  std::vector<PlannedFlow> flows;
};

/// Pure. `ports` of the device's modules; the connections were checked with them. An end whose module is not
/// known (a program that no connection names) has no link.
WiringPlan plan_wiring(const model::Cell& cell, std::size_t device,
                       const std::vector<model::ModulePorts>& ports);

/// The topic of a port: takt/<cell>/<device>/<module>/<port>.
std::string port_topic(const std::string& cell, const model::Endpoint& port);

/// What an operator wants to know of a port.
struct PortHealth {
  std::uint32_t connections = 0;  ///< of the descriptor; who listens or asks in is none
  std::uint32_t matched = 0;      ///< of these, with somebody at the other end
  std::uint64_t samples = 0;      ///< written, or taken
  std::uint64_t lost = 0;         ///< on the way between devices
  std::uint64_t dropped = 0;      ///< from full queues
  std::uint64_t refused = 0;      ///< values or bytes that are none of the type
  std::uint64_t late = 0;         ///< times that a value became older than its connection's deadline
  bool safe = false;              ///< of an input: its reader gets the safe value at present
  std::int64_t age_ns = -1;       ///< of the newest value; -1: there is none
  std::string incompatible{};     ///< the QoS policy that kept somebody from matching; empty: none
};

/// The links of a device, in memory. They live as long as this does, over restarts of the host and of
/// programs.
class Wiring {
 public:
  struct Wire {
    PlannedLink plan;
    os::SharedMemory memory;
    channel::Link link;
    bool late = false;      ///< as its supervisor found it last
    bool connected = true;  ///< by the descriptor
  };

  static Result<Wiring> create(WiringPlan plan);

  [[nodiscard]] const std::vector<Wire>& wires() const noexcept { return wires_; }
  /// Those that a module reads and whose values have a deadline.
  [[nodiscard]] std::vector<Wire*> with_deadline(std::uint32_t module);
  [[nodiscard]] const std::vector<PlannedFlow>& flows() const noexcept { return flows_; }

  /// The safe value of an output of another device.
  void give_safe(const model::SafeOutput& output);

  /// As the links tell it at this time (monotonic), and `on_dds` of those that go on there, by their index;
  /// it gives nothing for a link whose flow is not open.
  using OnDds = std::function<std::optional<dds::FlowHealth>(std::size_t wire)>;
  [[nodiscard]] PortHealth health(std::uint32_t module, const model::Port& port, std::int64_t now_ns,
                                  const OnDds& on_dds) const;

  /// What a host is told of the links of its modules.
  [[nodiscard]] std::vector<host::PortLink> of_host(const model::HostShare& host) const;
  /// What a program is told of its links: "PORT=FD,PORT=FD", the value of TAKT_LINKS.
  [[nodiscard]] std::string of_program(std::uint32_t module) const;
  /// The descriptors of all links of these, for whoever starts them.
  void inherit(std::vector<const os::Fd*>& into, const std::vector<host::PortLink>& links) const;
  void inherit(std::vector<const os::Fd*>& into, std::uint32_t module) const;

 private:
  std::vector<Wire> wires_;
  std::vector<PlannedFlow> flows_;
};

}  // namespace takt::node
