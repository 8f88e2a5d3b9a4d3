#include <takt/node/flow_manager.hpp>

#include <algorithm>
#include <set>
#include <utility>

#include <takt/node/log.hpp>

namespace takt::node {

using supervision::LinkEnd;
using supervision::PlannedFlow;
using supervision::PlannedLink;
using supervision::Wiring;

namespace {

// The number of bits in WakeWord::gateway_sleeps that bridges can use; one bit belongs to this node's own
// gateway.
constexpr std::uint32_t kMostBridges = 31;

}  // namespace

FlowManager::FlowManager(const Wiring& wiring, const std::string& device,
                         std::unique_ptr<dds::Gateway> gateway, std::unique_ptr<Worker> worker)
    : wiring_(wiring),
      device_(device),
      open_(wiring.flows().size()),
      flows_of_links_(wiring.links().size()),
      gateway_(std::move(gateway)),
      ids_(wiring.flows().size()),
      worker_(std::move(worker)) {
  for (std::size_t i = 0; i < wiring.flows().size(); ++i) {
    for (const std::size_t link : wiring.flows()[i].links) flows_of_links_[link] = i;
  }
}

Result<std::unique_ptr<FlowManager>> FlowManager::open(std::unique_ptr<dds::Gateway> gateway,
                                                       const os::SharedMemory& wake_word,
                                                       const Wiring& wiring, const model::Cell& cell,
                                                       const std::string& device) {
  auto worker = Worker::start("takt-flows");
  if (!worker) return worker.problems();
  auto flow_manager =
      std::unique_ptr<FlowManager>{new FlowManager{wiring, device, std::move(gateway), std::move(*worker)}};
  std::set<int> domains;
  for (std::size_t i = 0; i < wiring.flows().size(); ++i) {
    const PlannedFlow& flow = wiring.flows()[i];
    if (!flow.connected) continue;
    if (flow.domain.value_or(cell.domain) != cell.domain) {
      domains.insert(*flow.domain);
      continue;
    }
    flow_manager->open_[i].emplace();
    ++flow_manager->unopened_;
    flow_manager->worker_->add([me = flow_manager.get(), i] { me->open_connected(i); });
  }
  for (const int domain : domains) {
    if (auto opened = flow_manager->open_bridge(domain, wake_word, cell); !opened) return opened.problems();
  }
  return flow_manager;
}

dds::Flow FlowManager::flow_at(std::size_t index) const {
  const PlannedFlow& plan = wiring_.flows()[index];
  return {.topic = plan.topic,
          .type = plan.type,
          .quality = {.reliable = plan.reliable,
                      .depth = plan.depth,
                      .deadline = plan.deadline,
                      .lifespan = plan.lifespan,
                      .kept = plan.carries == model::Carries::replies}};
}

Result<void> FlowManager::open_bridge(int domain, const os::SharedMemory& wake_word,
                                      const model::Cell& cell) {
  Bridge::Options options{.device = device_,
                          .domain = domain,
                          .peers = cell.discovery.peers,
                          .wake_word = &wake_word,
                          .place = static_cast<std::uint32_t>(bridges_.size() + 1),
                          .flows = {}};
  if (options.place > kMostBridges)
    return fail("the connections of this device name more than " + std::to_string(kMostBridges) +
                " other domains; use fewer domains");
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < wiring_.flows().size(); ++i) {
    const PlannedFlow& plan = wiring_.flows()[i];
    if (!plan.connected || plan.domain != domain) continue;
    BridgedFlow flow{.flow = flow_at(i), .outgoing = plan.outgoing, .links = {}};
    for (const std::size_t link : plan.links) flow.links.push_back(&wiring_.links()[link].memory.memory());
    options.flows.push_back(std::move(flow));
    indices.push_back(i);
  }
  auto bridge = Bridge::start(std::move(options));
  if (!bridge) return bridge.problems();
  for (std::size_t i = 0; i < indices.size(); ++i)
    open_[indices[i]] = Open{.bridge = bridge->get(), .in_bridge = i};
  bridges_.push_back(std::move(*bridge));
  return {};
}

std::optional<Result<void>> FlowManager::opened() const {
  {
    const std::lock_guard lock{mutex_};
    if (!failure_.empty()) return Result<void>{failure_};
  }
  bool all = unopened_ == 0;
  for (const auto& bridge : bridges_) {
    const auto& opened = bridge->opened();
    if (opened && !opened->ok()) return opened;
    all &= opened.has_value();
  }
  return all ? std::optional{Result<void>{}} : std::nullopt;
}

Result<void> FlowManager::open_now(std::size_t index) {
  const PlannedFlow& plan = wiring_.flows()[index];
  const dds::Flow flow = flow_at(index);
  std::vector<channel::Link> links;
  for (const std::size_t link : plan.links) links.push_back(wiring_.links()[link].link);
  auto id = plan.outgoing ? gateway_->add_outgoing(flow, links.front()) : gateway_->add_incoming(flow, links);
  if (!id) {
    Problems problems = id.problems();
    for (Problem& problem : problems) problem.what = "topic " + plan.topic + ": " + problem.what;
    return problems;
  }
  ids_[index] = *id;
  return {};
}

void FlowManager::open_connected(std::size_t index) {
  if (auto opened = open_now(index); !opened) {
    const std::lock_guard lock{mutex_};
    failure_ = opened.problems();
  } else {
    --unopened_;
  }
}

void FlowManager::open_unconnected(std::size_t index) {
  // The link is enabled first: a client may send its request as soon as DDS has matched the flow of the
  // replies, and the module must be able to reply then.
  auto& enabled = wiring_.links()[wiring_.flows()[index].links.front()].link.block().enabled;
  enabled.store(1, std::memory_order_relaxed);
  if (auto opened = open_now(index); !opened) {
    enabled.store(0, std::memory_order_relaxed);
    log(device_, "", "warning: " + in_words(opened.problems()));
  }
}

void FlowManager::close_now(std::size_t index) {
  if (const auto id = ids_[index].exchange(0); id != 0) gateway_->remove(id);
  const PlannedFlow& flow = wiring_.flows()[index];
  if (flow.outgoing)
    wiring_.links()[flow.links.front()].link.block().enabled.store(0, std::memory_order_relaxed);
}

Result<void> FlowManager::tap(std::uint32_t module, const std::string& port, Instant until,
                              Nanoseconds every) {
  const PlannedFlow* flow = wiring_.flow_of(module, port);
  if (flow == nullptr) return fail("there is no output '" + port + "'");
  const auto index = static_cast<std::size_t>(flow - wiring_.flows().data());
  open_until(index, until);
  Open& open = *open_[index];
  if (!open.until || flow->carries != model::Carries::samples) return {};
  if (every.count() == 0)
    open.whole_until = std::max(open.whole_until.value_or(until), until);
  else
    open.every = open.every.count() == 0 ? every : std::min(open.every, every);
  thin_out(index);
  return {};
}

/// Passes on how many samples the observers of an unconnected output want.
void FlowManager::thin_out(std::size_t index) {
  const Nanoseconds every = open_[index]->whole_until ? Nanoseconds{0} : open_[index]->every;
  worker_->add([this, index, every] {
    if (const auto id = ids_[index].load(); id != 0) gateway_->thin_out(id, every);
  });
}

void FlowManager::open_until(std::size_t index, Instant until) {
  if (open_[index]) {
    if (open_[index]->until) open_[index]->until = std::max(*open_[index]->until, until);
    return;
  }
  open_[index] = Open{.until = until};
  worker_->add([this, index] { open_unconnected(index); });
}

Result<void> FlowManager::open_service(std::uint32_t module, const std::string& service, Instant until) {
  for (std::size_t i = 0; i < wiring_.flows().size(); ++i) {
    const PlannedFlow& flow = wiring_.flows()[i];
    if (flow.connected) continue;
    const PlannedLink& link = wiring_.links()[flow.links.front()].plan;
    const LinkEnd end{module, service + (flow.outgoing ? model::kReplyPort : model::kRequestPort)};
    if ((flow.outgoing ? link.from : link.to) != end) continue;
    open_until(i, until);
  }
  return {};
}

// Enables the request links of this device's clients while the service of the client is found, and disables
// them otherwise. A request on a disabled link is not sent, so its client learns at once that there is no
// service.
void FlowManager::enable_requests() {
  for (std::size_t i = 0; i < wiring_.flows().size(); ++i) {
    const PlannedFlow& flow = wiring_.flows()[i];
    if (!flow.outgoing || flow.carries != model::Carries::requests || !open_[i]) continue;
    const Wiring::CreatedLink& created = wiring_.links()[flow.links.front()];
    const std::string& request = created.plan.from.port;
    LinkEnd reply = created.plan.from;
    reply.port = request.substr(0, request.rfind('/')) + model::kReplyPort;
    bool answered = false;
    for (std::size_t w = 0; w < wiring_.links().size(); ++w) {
      if (wiring_.links()[w].plan.to != reply) continue;
      const auto replies = health(w);
      answered = answered || (replies && replies->matched > 0);
    }
    const bool served = answered && health(flow.links.front()).value_or(wire::FlowHealth{}).matched > 0;
    created.link.block().enabled.store(served ? 1 : 0, std::memory_order_relaxed);
  }
}

void FlowManager::step(Instant now) {
  for (const auto& bridge : bridges_) bridge->step(now);
  enable_requests();
  for (std::size_t i = 0; i < open_.size(); ++i) {
    if (!open_[i] || !open_[i]->until) continue;
    if (now < *open_[i]->until) {
      if (!open_[i]->whole_until || now < *open_[i]->whole_until) continue;
      open_[i]->whole_until.reset();
      thin_out(i);
      continue;
    }
    open_[i].reset();
    worker_->add([this, i] { close_now(i); });
  }
}

std::optional<wire::FlowHealth> FlowManager::health(std::size_t link) const {
  const auto flow = flows_of_links_[link];
  if (!flow || !open_[*flow]) return std::nullopt;
  if (const Open& open = *open_[*flow]; open.bridge != nullptr) return open.bridge->health(open.in_bridge);
  const dds::Gateway::FlowId id = ids_[*flow];
  return id == 0 ? std::nullopt : std::optional{gateway_->health(id)};
}

}  // namespace takt::node
