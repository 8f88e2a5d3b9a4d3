#include <takt/agent/problems_json.hpp>
#include <takt/node/bridge.hpp>

#include <utility>

#include <nlohmann/json.hpp>

#include <takt/channel/link.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/node/log.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/signals.hpp>

namespace takt::node {

using agent::problems_from;
using agent::problems_json;

namespace {

using json = nlohmann::ordered_json;

constexpr Nanoseconds kOpenedWithin = std::chrono::seconds{10};
constexpr Nanoseconds kBetweenStarts = std::chrono::seconds{1};
constexpr int kReportEveryMs = 250;

std::optional<Nanoseconds> duration(const json& value) {
  return value.is_null() ? std::nullopt : std::optional{Nanoseconds{value.get<std::int64_t>()}};
}

json duration(const std::optional<Nanoseconds>& value) {
  return value ? json(value->count()) : json(nullptr);
}

// Converts a flow to JSON. Because only ports have a JSON form, the flow's data type is written as the type
// of a port.
json to_json(const dds::Flow& flow) {
  model::Port port;
  port.name = "port";
  port.direction = model::Direction::out;
  port.type = flow.type;
  return {{"topic", flow.topic},
          {"port", model::ports_json({port})},
          {"reliable", flow.quality.reliable},
          {"depth", flow.quality.depth},
          {"deadline", duration(flow.quality.deadline)},
          {"lifespan", duration(flow.quality.lifespan)}};
}

Result<dds::Flow> flow_from(const json& value) {
  auto ports = model::parse_ports(value.at("port"));
  if (!ports) return ports.problems();
  return dds::Flow{.topic = value.at("topic"),
                   .type = std::move(ports->at(0).type),
                   .quality = {.reliable = value.at("reliable"),
                               .depth = value.at("depth"),
                               .deadline = duration(value.at("deadline")),
                               .lifespan = duration(value.at("lifespan"))}};
}

json to_json(const wire::FlowHealth& health) {
  return {{"matched", health.matched},          {"samples", health.samples}, {"lost", health.lost},
          {"refused", health.refused},          {"untimed", health.untimed}, {"failures", health.failures},
          {"incompatible", health.incompatible}};
}

wire::FlowHealth health_from(const json& value) {
  return {.matched = value.at("matched"),
          .samples = value.at("samples"),
          .lost = value.at("lost"),
          .refused = value.at("refused"),
          .untimed = value.at("untimed"),
          .failures = value.at("failures"),
          .incompatible = value.at("incompatible")};
}

/// The work of the bridge process. Holds the memory of the links, and the gateway that uses this memory.
class BridgeProgram {
 public:
  Result<void> open(const json& request, const std::vector<std::string>& interfaces) {
    model::Discovery discovery;
    discovery.peers = request.at("peers").get<std::vector<std::string>>();
    if (!discovery.peers.empty()) discovery.kind = model::Discovery::Kind::peers;
    const std::string device = request.at("device");
    auto participant =
        dds::Participant::create({.name = "takt-gateway " + device,
                                  .domain = request.at("domain"),
                                  .discovery = discovery,
                                  .interfaces = interfaces,
                                  .security = os::environment("TAKT_SECURITY"),
                                  .told = [device](const std::string& text) { log(device, "", text); }});
    if (!participant) return participant.problems();
    participant_ = std::move(*participant);
    auto wake_word = attach(request.at("wake_word"));
    if (!wake_word) return wake_word.problems();
    auto gateway = dds::Gateway::create(participant_, *reinterpret_cast<channel::WakeWord*>(*wake_word),
                                        request.at("place").get<std::uint32_t>());
    if (!gateway) return gateway.problems();
    gateway_ = std::move(*gateway);
    for (const json& each : request.at("flows")) {
      auto flow = flow_from(each);
      if (!flow) return flow.problems();
      std::vector<channel::Link> links;
      for (const json& fd : each.at("links")) {
        auto memory = attach(fd);
        if (!memory) return memory.problems();
        links.emplace_back(*memory);
      }
      auto id = each.at("outgoing") ? gateway_->add_outgoing(*flow, links.front())
                                    : gateway_->add_incoming(*flow, links);
      if (!id) {
        Problems problems = id.problems();
        for (Problem& problem : problems) problem.what = "topic " + flow->topic + ": " + problem.what;
        return problems;
      }
      flows_.push_back(*id);
    }
    return {};
  }

  [[nodiscard]] json health() const {
    json list = json::array();
    for (const auto id : flows_) list.push_back(to_json(gateway_->health(id)));
    return {{"health", list}};
  }

 private:
  Result<std::byte*> attach(int fd) {
    auto memory = os::SharedMemory::attach(os::adopt_fd(fd));
    if (!memory) return memory.problems();
    memories_.push_back(std::move(*memory));
    return memories_.back().data();
  }

  std::vector<os::SharedMemory> memories_;
  std::shared_ptr<dds::Participant> participant_;
  std::unique_ptr<dds::Gateway> gateway_;  // declared after memories_, so that it is destroyed before them
  std::vector<dds::Gateway::FlowId> flows_;
};

}  // namespace

Bridge::Bridge(Options options) : options_(std::move(options)), health_(options_.flows.size()) {}
Bridge::~Bridge() = default;

Result<std::unique_ptr<Bridge>> Bridge::start(Options options) {
  auto gateway = std::unique_ptr<Bridge>{new Bridge{std::move(options)}};
  if (auto spawned = gateway->spawn(); !spawned) return spawned.problems();
  return gateway;
}

Result<void> Bridge::spawn() {
  auto sockets = os::MessageSocket::pair();
  if (!sockets) return sockets.problems();
  socket_ = std::move(sockets->first);
  const os::MessageSocket theirs = std::move(sockets->second);
  os::SpawnOptions spawn{.program = os::program_directory() + "/takt-node",
                         .environment = {{kGatewayFd, std::to_string(theirs.fd().get())}},
                         .inherit = {&theirs.fd(), &options_.wake_word->fd()}};
  json flows = json::array();
  for (const BridgedFlow& each : options_.flows) {
    json flow = to_json(each.flow);
    flow["outgoing"] = each.outgoing;
    flow["links"] = json::array();
    for (const os::SharedMemory* memory : each.links) {
      flow["links"].push_back(memory->fd().get());
      spawn.inherit.push_back(&memory->fd());
    }
    flows.push_back(std::move(flow));
  }
  auto child = os::Child::spawn(spawn);
  if (!child) return child.problems();
  child_ = std::move(*child);
  started_ = os::now();
  socket_.send(model::json_text({{"device", options_.device},
                                 {"domain", options_.domain},
                                 {"peers", options_.peers},
                                 {"wake_word", options_.wake_word->fd().get()},
                                 {"place", options_.place},
                                 {"flows", flows}}));
  return {};
}

void Bridge::handle(const std::string& text) {
  const json news = model::parse_json(text);
  if (news.contains("problems")) {
    const Problems problems = problems_from(news["problems"]);
    if (opened_) log(options_.device, "", in_words(problems));
    if (!opened_) opened_ = problems;
  } else if (news.contains("health")) {
    if (!opened_) opened_ = Result<void>{};
    for (std::size_t i = 0; i < health_.size(); ++i) health_[i] = health_from(news["health"].at(i));
  }
}

void Bridge::step(Instant now) {
  socket_.flush();
  while (const auto text = socket_.receive()) handle(*text);
  const std::string name = "the bridge to domain " + std::to_string(options_.domain);
  if (const auto end = child_.poll()) {
    // The bridge process may have been asleep when it ended. Clear its bit in the wake word, so that writers
    // no longer try to wake the process.
    auto& wake_word = *reinterpret_cast<channel::WakeWord*>(options_.wake_word->data());
    wake_word.gateway_sleeps.fetch_and(~(1U << options_.place), std::memory_order_seq_cst);
    for (wire::FlowHealth& health : health_) health.matched = 0;
    if (!opened_) opened_ = fail(name + " " + end->text());
    log(options_.device, "", name + " " + end->text());
  }
  if (!opened_ && now - started_ > kOpenedWithin)
    opened_ = fail(name + " did not open its topics within " + to_text(kOpenedWithin));
  if (child_.running() || now - started_ < kBetweenStarts) return;
  if (auto spawned = spawn(); !spawned) {
    log(options_.device, "", name + ": " + in_words(spawned.problems()));
    started_ = now;
  }
}

int run_bridge(const std::vector<std::string>& interfaces) {
  os::survive_broken_pipes();
  os::MessageSocket node{os::take_fd_from_environment(kGatewayFd)};
  const auto text = node.receive_wait();
  const json request = text ? model::parse_json(*text) : json{};
  if (!request.is_object()) return 1;
  BridgeProgram program;
  if (auto opened = program.open(request, interfaces); !opened) {
    node.send_wait(model::json_text({{"problems", problems_json(opened.problems())}}));
    return 1;
  }
  while (node.send_wait(model::json_text(program.health()))) {
    os::wait_readable({&node.fd()}, kReportEveryMs);
    static_cast<void>(node.receive());
    if (node.closed()) break;
  }
  return 0;
}

}  // namespace takt::node
