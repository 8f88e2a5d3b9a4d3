#include <takt/node/gate.hpp>

#include <algorithm>
#include <utility>

namespace takt::node {

Result<std::unique_ptr<Gate>> Gate::open(std::shared_ptr<dds::Participant> participant, channel::Bell& bell,
                                         const Wiring& wiring, int domain) {
  auto gate = std::unique_ptr<Gate>{new Gate{wiring}};
  auto gateway = dds::Gateway::create(std::move(participant), bell);
  if (!gateway) return gateway.problems();
  gate->gateway_ = std::move(*gateway);
  for (std::size_t i = 0; i < wiring.flows().size(); ++i) {
    const PlannedFlow& flow = wiring.flows()[i];
    if (!flow.connected) continue;
    if (flow.domain && *flow.domain != domain) {
      return fail("the topic " + flow.topic + " is on domain " + std::to_string(*flow.domain) +
                      ", and this node on domain " + std::to_string(domain),
                  "a node moves samples on its own domain only; leave out domain, or run the other program "
                  "on domain " +
                      std::to_string(domain));
    }
    if (auto opened = gate->open_flow(i, std::nullopt); !opened) return opened.problems();
  }
  return gate;
}

Result<void> Gate::open_flow(std::size_t index, std::optional<Instant> until) {
  const PlannedFlow& plan = wiring_.flows()[index];
  const dds::Flow flow{.topic = plan.topic,
                       .type = plan.type,
                       .quality = {.reliable = plan.reliable,
                                   .depth = plan.depth,
                                   .deadline = plan.deadline,
                                   .lifespan = plan.lifespan}};
  std::vector<channel::Link> links;
  for (const std::size_t wire : plan.links) links.push_back(wiring_.wires()[wire].link);
  auto id = plan.outgoing ? gateway_->add_outgoing(flow, links.front()) : gateway_->add_incoming(flow, links);
  if (!id) {
    Problems problems = id.problems();
    for (Problem& problem : problems) problem.what = "topic " + plan.topic + ": " + problem.what;
    return problems;
  }
  open_[index] = Open{*id, until};
  return {};
}

const PlannedFlow* Gate::flow_of(std::uint32_t module, const std::string& port) const {
  const auto found =
      std::find_if(wiring_.flows().begin(), wiring_.flows().end(), [&](const PlannedFlow& flow) {
        return flow.outgoing && wiring_.wires()[flow.links.front()].plan.from == LinkEnd{module, port};
      });
  return found == wiring_.flows().end() ? nullptr : &*found;
}

Result<void> Gate::tap(std::uint32_t module, const std::string& port, Instant until) {
  const PlannedFlow* flow = flow_of(module, port);
  if (flow == nullptr) return fail("there is no output '" + port + "'");
  const auto index = static_cast<std::size_t>(flow - wiring_.flows().data());
  if (open_[index]) {
    if (open_[index]->until) open_[index]->until = std::max(*open_[index]->until, until);
    return {};
  }
  if (auto opened = open_flow(index, until); !opened) return opened;
  wiring_.wires()[flow->links.front()].link.block().enabled.store(1, std::memory_order_relaxed);
  return {};
}

void Gate::step(Instant now) {
  for (std::size_t i = 0; i < open_.size(); ++i) {
    if (!open_[i] || !open_[i]->until || now < *open_[i]->until) continue;
    wiring_.wires()[wiring_.flows()[i].links.front()].link.block().enabled.store(0,
                                                                                 std::memory_order_relaxed);
    gateway_->remove(open_[i]->id);
    open_[i].reset();
  }
}

std::optional<dds::FlowHealth> Gate::health(std::size_t wire) const {
  for (std::size_t i = 0; i < open_.size(); ++i) {
    const std::vector<std::size_t>& wires = wiring_.flows()[i].links;
    if (!open_[i] || std::find(wires.begin(), wires.end(), wire) == wires.end()) continue;
    return gateway_->health(open_[i]->id);
  }
  return std::nullopt;
}

}  // namespace takt::node
