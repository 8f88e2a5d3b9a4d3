#include <takt/supervision/wiring.hpp>

#include <algorithm>
#include <tuple>

#include <takt/channel/release_slot.hpp>
#include <takt/schedule/logical_time.hpp>

namespace takt::supervision {

namespace {

using model::Connection;
using model::ConnectionKind;
using model::Direction;
using model::Endpoint;

/// The depth of ROS 2's default profile (rmw_qos_profile_default), in samples.
constexpr std::uint32_t kRos2Depth = 10;

constexpr std::uint32_t kTapDepth = 64;
constexpr std::uint32_t kTapBytes = 16 * 1024;

class Planner {
 public:
  Planner(const model::Cell& cell, std::size_t device, const std::vector<model::ModulePorts>& ports)
      : cell_(cell), device_(cell.devices[device]), ports_(ports), hosts_(model::hosts_of(device_)) {}

  WiringPlan plan() {
    for (const Connection& connection : cell_.connections) {
      const bool from_here = is_here(connection.from);
      const bool to_here = is_here(connection.to);
      if (from_here && to_here && connection.topic.empty())
        within(connection);
      else {
        if (from_here) outgoing(connection);
        if (to_here) incoming(connection);
      }
    }
    // Observers can read outputs without a connection, and programs outside the cell can call services.
    for (std::uint32_t module = 0; module < ports_.size(); ++module) {
      if (!ports_[module]) continue;
      for (const model::Port& port : *ports_[module]) {
        if (port.direction == Direction::out)
          flow_of(module, port, topic_of(module, port.name), std::nullopt);
        if (answers(port)) serve_outside_calls(module, port);
      }
    }
    for (const PlannedFlow& flow : plan_.flows) {
      if (flow.outgoing && !flow.connected && flow.carries == model::Carries::samples)
        deepen_for_taps(plan_.links[flow.links.front()].options);
    }
    return std::move(plan_);
  }

 private:
  [[nodiscard]] bool is_here(const Endpoint& end) const { return end.given() && end.device == device_.name; }

  struct Port {
    std::uint32_t module;
    const model::Port* port;
  };
  /// Returns the port at `end`; nothing if there is no such port or the module's ports are not known.
  [[nodiscard]] std::optional<Port> find(const Endpoint& end) const {
    for (std::uint32_t module = 0; module < ports_.size(); ++module) {
      if (device_.modules[module].name != end.module || !ports_[module]) continue;
      for (const model::Port& port : *ports_[module]) {
        if (port.name == end.port) return Port{module, &port};
      }
    }
    return std::nullopt;
  }
  [[nodiscard]] std::string topic_of(std::uint32_t module, const std::string& port) const {
    return port_topic(cell_.name, {device_.name, device_.modules[module].name, port});
  }
  /// True if the port receives the requests of a service.
  static bool answers(const model::Port& port) {
    return (port.role == model::Role::service || port.role == model::Role::handler) &&
           port.direction != Direction::out;
  }
  /// The bits of the wake word that a sample for this port sets.
  [[nodiscard]] std::uint32_t wake_bits(const Port& to) const {
    const model::Module& module = device_.modules[to.module];
    if (to.port->role == model::Role::handler) return channel::kServiceBit;
    if (to.port->direction != Direction::event || module.dispatch != model::Dispatch::immediate) return 0;
    return module.type == model::ModuleType::thread ? channel::kSporadicBit : channel::wake_bit(to.module);
  }

  /// True if a link between two modules holds C++ objects. Only links within the shared host hold C++
  /// objects. The links of an executor's own host must survive a crash of this host, so they hold bytes.
  [[nodiscard]] bool as_objects(std::uint32_t one, std::uint32_t other) const {
    return std::any_of(hosts_.begin(), hosts_.end(), [&](const model::HostShare& host) {
      const auto has = [&](std::uint32_t module) {
        return std::find(host.modules.begin(), host.modules.end(), module) != host.modules.end();
      };
      return !host.is_own() && has(one) && has(other);
    });
  }

  static std::uint32_t payload_of(const model::Port& port) {
    return static_cast<std::uint32_t>(model::max_size(port.type));
  }
  static channel::Link::Options options_of(const Connection& connection, const model::Port& port) {
    return {.depth = static_cast<std::uint32_t>(connection.depth),
            .payload = payload_of(port),
            .is_queue = connection.kind == ConnectionKind::queue,
            .wake_bits = 0,
            .deadline_ns = connection.deadline.value_or(Nanoseconds{0}).count(),
            .enabled = true};
  }

  /// The bytes that a link reserves for a forced value of its reader.
  static std::uint32_t force_room(const Connection& connection, const model::Port& to) {
    const bool forceable = to.direction == Direction::in && to.role == model::Role::plain &&
                           connection.kind == ConnectionKind::latest;
    return forceable && payload_of(to) <= kMostForced ? payload_of(to) : 0;
  }

  [[nodiscard]] std::uint32_t ahead(std::uint32_t writer, const model::Module* reader) const {
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(
        schedule::samples_ahead(device_, device_.modules[writer], reader), channel::kMaxLinkDepth - 1));
  }

  void within(const Connection& connection) {
    const auto from = find(connection.from);
    const auto to = find(connection.to);
    if (!from || !to) return;
    PlannedLink link{.from = {from->module, from->port->name},
                     .to = {to->module, to->port->name},
                     .connections = {{device_.name, 1}}};
    link.options = options_of(connection, *from->port);
    link.options.depth = std::min(link.options.depth + ahead(from->module, &device_.modules[to->module]),
                                  channel::kMaxLinkDepth);
    link.options.wake_bits = wake_bits(*to);
    link.stale = connection.stale;
    link.typed = from->port->object && to->port->object && as_objects(from->module, to->module);
    if (link.typed) link.options.payload = 0;
    if (may_be_safe(connection, *to->port)) {
      link.safe = safe_bytes(device_.modules[from->module], *from->port);
      if (!link.safe.empty()) link.writer = connection.from;
    }
    if (link.writer.given()) link.options.safe = payload_of(*from->port);
    link.options.force = force_room(connection, *to->port);
    plan_.links.push_back(link);
  }

  /// Returns the flow of an output to a topic. If there is no such flow yet, plans the flow and its link to
  /// the gateway.
  PlannedFlow& flow_of(std::uint32_t module, const model::Port& port, const std::string& topic,
                       std::optional<int> domain) {
    for (PlannedFlow& flow : plan_.flows) {
      if (flow.outgoing && flow.topic == topic && flow.domain == domain &&
          plan_.links[flow.links.front()].from == LinkEnd{module, port.name}) {
        return flow;
      }
    }
    PlannedLink link{.from = {module, port.name}, .to = {}};
    link.options = {.depth = 1 + ahead(module, nullptr),
                    .payload = payload_of(port),
                    .wake_bits = channel::kGatewayBit,
                    .enabled = false};
    // True if the port sends the replies of a service. A reply may go to any client.
    const bool replies = port.role == model::Role::service || port.role == model::Role::handler;
    if (replies) {
      link.options.depth += static_cast<std::uint32_t>(model::kServiceDepth);
      link.options.is_queue = true;
    }
    plan_.links.push_back(link);
    plan_.flows.push_back({.outgoing = true,
                           .topic = topic,
                           .domain = domain,
                           .type = port.type,
                           .reliable = replies,
                           .depth = replies ? static_cast<std::uint32_t>(model::kServiceDepth) : 1,
                           .carries = replies ? model::Carries::replies : model::Carries::samples,
                           .links = {plan_.links.size() - 1}});
    return plan_.flows.back();
  }

  /// Makes the link of a tapped output (`takt record`) deep enough for the samples that are written while the
  /// node waits for a CPU.
  static void deepen_for_taps(channel::Link::Options& link) {
    const std::uint32_t fit = kTapBytes / std::max(link.payload, 1U);
    link.depth = std::max(link.depth, std::min(fit, kTapDepth));
    link.is_queue = true;  // only a queue counts the samples that it drops
  }

  static std::string text_of(const Connection& connection) {
    return model::to_text(connection.from) + " -> " + model::to_text(connection.to);
  }

  /// Plans the flow for a connection that begins at an output of this device. All connections of the output
  /// to the same topic share one flow, which gets the strictest QoS of these connections.
  void outgoing(const Connection& connection) {
    const auto from = find(connection.from);
    if (!from) return;
    PlannedFlow& flow =
        flow_of(from->module, *from->port, model::topic_of(cell_, connection), connection.domain);
    flow.carries = connection.carries;
    ++plan_.links[flow.links.front()].connections[connection.to.device];
    channel::Link::Options& link = plan_.links[flow.links.front()].options;
    const auto depth = static_cast<std::uint32_t>(connection.depth);
    link.enabled = connection.carries != model::Carries::requests;  // a link for requests is enabled only
                                                                    // while a service is matched
    link.depth = std::max(link.depth, depth);
    link.is_queue |= connection.kind == ConnectionKind::queue;
    // As ROS 2 does by default, the flow offers at least the last ten samples to readers of ROS 2.
    flow.depth = std::max(flow.depth, connection.ros2 ? std::max(depth, kRos2Depth) : depth);
    flow.reliable |= connection.reliability == model::Reliability::reliable;
    // The flow gets the shortest deadline and the longest lifespan of all its connections.
    if (connection.deadline)
      flow.deadline = std::min(flow.deadline.value_or(*connection.deadline), *connection.deadline);
    if (!flow.connected) {
      flow.lifespan = connection.lifespan;
    } else if (flow.lifespan) {
      flow.lifespan =
          connection.lifespan ? std::optional{std::max(*flow.lifespan, *connection.lifespan)} : std::nullopt;
    }
    flow.connected = true;
    if (connection.to.given()) flow.ends.try_emplace(connection.to.device, text_of(connection));
  }

  void incoming(const Connection& connection) {
    const auto to = find(connection.to);
    if (!to) return;
    PlannedLink link{
        .from = {}, .to = {to->module, to->port->name}, .connections = {{connection.from.device, 1}}};
    if (connection.from.given() && !is_here(connection.from)) link.sender = connection.from.device;
    link.options = options_of(connection, *to->port);
    link.options.wake_bits = wake_bits(*to);
    link.options.force = force_room(connection, *to->port);
    link.stale = connection.stale;
    if (may_be_safe(connection, *to->port)) {
      link.writer = connection.from;
      link.options.safe = payload_of(*to->port);
      if (const auto from = is_here(connection.from) ? find(connection.from) : std::nullopt)
        link.safe = safe_bytes(device_.modules[from->module], *from->port);
    }
    plan_.links.push_back(link);

    PlannedFlow flow{.outgoing = false,
                     .topic = model::topic_of(cell_, connection),
                     .domain = connection.domain,
                     .type = to->port->type,
                     .reliable = connection.reliability == model::Reliability::reliable,
                     .depth = static_cast<std::uint32_t>(connection.depth),
                     // Writers of ROS 2 offer no deadline, so a reader that requests a deadline would not
                     // match. Instead, the link checks the deadline.
                     .deadline = connection.ros2 ? std::nullopt : connection.deadline,
                     .lifespan = connection.lifespan,
                     .carries = connection.carries,
                     .connected = true,
                     .links = {plan_.links.size() - 1}};
    if (connection.from.given()) flow.ends.emplace(connection.from.device, text_of(connection));
    const auto same = [](const PlannedFlow& f) {
      return std::tie(f.outgoing, f.topic, f.domain, f.reliable, f.depth, f.deadline, f.lifespan);
    };
    const auto other = std::find_if(plan_.flows.begin(), plan_.flows.end(), [&](const PlannedFlow& f) {
      return same(f) == same(flow) && f.type == flow.type;
    });
    if (other == plan_.flows.end()) {
      plan_.flows.push_back(std::move(flow));
    } else {
      other->links.push_back(plan_.links.size() - 1);
      other->ends.merge(flow.ends);
    }
  }

  /// Plans the flow of requests from outside the cell (`takt call`). The replies use the flow that every
  /// output has. Both links come after the links of all connections, so that a service's links for replies
  /// have the same order as its links for requests.
  void serve_outside_calls(std::uint32_t module, const model::Port& port) {
    PlannedLink link{.from = {}, .to = {module, port.name}};
    link.options = {.depth = static_cast<std::uint32_t>(model::kServiceDepth),
                    .payload = payload_of(port),
                    .is_queue = true,
                    .wake_bits = wake_bits({module, &port})};
    plan_.links.push_back(link);
    plan_.flows.push_back({.outgoing = false,
                           .topic = topic_of(module, port.name),
                           .domain = {},
                           .type = port.type,
                           .reliable = true,
                           .depth = link.options.depth,
                           .carries = model::Carries::requests,
                           .links = {plan_.links.size() - 1}});
  }

  const model::Cell& cell_;
  const model::Device& device_;
  const std::vector<model::ModulePorts>& ports_;
  const std::vector<model::HostShare> hosts_;
  WiringPlan plan_;
};

}  // namespace

std::string port_topic(const std::string& cell, const Endpoint& port) {
  return "takt/" + cell + "/" + port.device + "/" + port.module + "/" + port.port;
}

WiringPlan plan_wiring(const model::Cell& cell, std::size_t device,
                       const std::vector<model::ModulePorts>& ports) {
  return Planner{cell, device, ports}.plan();
}

Result<Wiring> Wiring::create(WiringPlan plan) {
  Wiring wiring;
  wiring.flows_ = std::move(plan.flows);
  for (PlannedLink& planned : plan.links) {
    auto memory =
        channel::Shared<std::byte>::create("takt-link", channel::Link::layout(planned.options).size());
    if (!memory) return memory.problems();
    channel::Link::format(memory->data(), planned.options);
    const channel::Link link{memory->data()};
    link.give_safe(planned.safe);
    wiring.links_.push_back({std::move(planned), std::move(*memory), link});
  }
  return wiring;
}

std::vector<Wiring::CreatedLink*> Wiring::with_deadline(std::uint32_t module) {
  std::vector<CreatedLink*> found;
  for (CreatedLink& created : links_) {
    if (created.plan.to.module == module && created.plan.options.deadline_ns > 0) found.push_back(&created);
  }
  return found;
}

void Wiring::give_safe(const model::SafeOutput& output) {
  for (const CreatedLink& created : links_) {
    if (created.plan.writer != output.port || !created.link.safe().empty()) continue;
    const auto flow = std::find_if(flows_.begin(), flows_.end(), [&](const PlannedFlow& each) {
      return std::any_of(each.links.begin(), each.links.end(),
                         [&](std::size_t index) { return &links_[index] == &created; });
    });
    if (flow == flows_.end()) continue;
    if (const auto bytes = model::sample_bytes(flow->type, output.json); bytes)
      created.link.give_safe(*bytes);
  }
}

namespace {

/// The connections of a link.
struct Connections {
  std::uint32_t all = 0;
  std::uint32_t of_cell = 0;  ///< those whose other end belongs to the cell
  std::uint32_t present = 0;  ///< those whose other end is not on a lost device
  std::uint32_t ends = 0;     ///< the devices that are not lost, and programs outside, at the other ends

  Connections(const std::map<std::string, std::uint32_t>& connections, const Wiring::IsLost& is_lost) {
    for (const auto& [device, count] : connections) {
      all += count;
      of_cell += device.empty() ? 0 : count;
      if (!device.empty() && is_lost && is_lost(device)) continue;
      present += count;
      ++ends;
    }
  }
  /// Returns how many connections are matched if `found` ends have been found. DDS does not tell which ends
  /// these are, so each of them counts as one connection until all ends have been found.
  [[nodiscard]] std::uint32_t matched(std::uint32_t found) const {
    return found >= ends ? present : std::min(found, present);
  }
};

}  // namespace

std::string Wiring::unmatched(const OnDds& on_dds) const {
  for (const PlannedFlow& flow : flows_) {
    if (flow.ends.empty()) continue;
    const auto health = on_dds(flow.links.front());
    if (health && health->matched >= flow.ends.size()) continue;
    std::string text;
    for (const auto& [device, connection] : flow.ends) text += (text.empty() ? "" : " or ") + connection;
    return text;
  }
  return "";
}

PortHealth Wiring::health(std::uint32_t module, const model::Port& port, std::int64_t now_ns,
                          const OnDds& on_dds, const IsLost& is_lost) const {
  constexpr auto relaxed = std::memory_order_relaxed;
  const bool output = port.direction == model::Direction::out;
  PortHealth health;
  std::int64_t newest = 0;
  for (std::size_t i = 0; i < links_.size(); ++i) {
    const CreatedLink& created = links_[i];
    const LinkEnd& end = output ? created.plan.from : created.plan.to;
    if (end.module != module || end.port != port.name) continue;
    const bool enabled = created.link.block().enabled.load(relaxed) != 0;
    const bool goes_on = !(output ? created.plan.to : created.plan.from).module;
    const Connections connections{created.plan.connections, is_lost};
    std::uint32_t others = goes_on ? 0 : connections.ends;
    if (const auto flow = goes_on ? on_dds(i) : std::nullopt) {
      others = flow->matched;
      health.lost += flow->lost + flow->failures;
      health.refused += flow->refused;
      health.untimed += flow->untimed;
      if (health.incompatible.empty()) health.incompatible = flow->incompatible;
    }
    const std::uint32_t matched = enabled ? connections.matched(others) : 0;
    health.connections += connections.all;
    health.matched += matched;
    health.missing += connections.of_cell - std::min(matched, connections.of_cell);
    const channel::LinkBlock& block = created.link.block();
    const std::uint64_t written = block.written.load(relaxed);
    // An output writes each sample to all its enabled links, so the output's count is the highest count of
    // these links.
    health.samples = output ? std::max(health.samples, written) : health.samples + block.taken.load(relaxed);
    if (created.connected() && block.is_queue != 0) health.dropped += block.overwritten.load(relaxed);
    if (const Nanoseconds deadline{block.deadline_ns}; !output && deadline.count() > 0)
      health.deadline = std::min(health.deadline.value_or(deadline), deadline);
    health.refused += output ? block.unfit.load(relaxed) : block.refused.load(relaxed);
    health.late += block.late.load(relaxed);
    newest = std::max(newest, block.newest_ns.load(relaxed));
    if (!output && !created.link.safe().empty() && !created.link.is_forced(now_ns)) {
      const std::int64_t last = block.newest_ns.load(relaxed);
      health.safe |= created.link.trusted_from() > written || written == 0 ||
                     (block.deadline_ns > 0 && now_ns - last > block.deadline_ns);
    }
  }
  if (newest != 0) health.age_ns = std::max<std::int64_t>(now_ns - newest, 0);
  return health;
}

const PlannedFlow* Wiring::flow_of(std::uint32_t module, const std::string& port) const {
  const auto found = std::find_if(flows_.begin(), flows_.end(), [&](const PlannedFlow& flow) {
    return flow.outgoing && links_[flow.links.front()].plan.from == LinkEnd{module, port};
  });
  return found == flows_.end() ? nullptr : &*found;
}

}  // namespace takt::supervision
