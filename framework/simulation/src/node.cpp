#include "node.hpp"

#include <utility>

#include <takt/wire/words.hpp>
#include "network.hpp"
#include "virtual_platform.hpp"

namespace takt::simulation {

namespace {

using std::chrono::milliseconds;

/// The interval at which a node checks its modules.
constexpr Nanoseconds kStepEvery = milliseconds{5};
/// The interval at which a node publishes its status.
constexpr Nanoseconds kBeatEvery = milliseconds{100};
/// A node from which nothing arrives for this time is lost.
constexpr Nanoseconds kLease = milliseconds{300};

std::string id_of(const std::string& device) { return "node of " + device; }

/// The inspection of components that are not there: it only returns the known ports.
class Inspection final : public agent::Inspection {
 public:
  explicit Inspection(agent::Inspected found) : found_(std::move(found)) {}
  std::optional<Result<agent::Inspected>> result() override { return found_; }

 private:
  agent::Inspected found_;
};

/// A fault record that ends with the simulation. The trace shows the events.
class FaultMemory final : public agent::FaultMemory {
 public:
  void append(model::Fault& fault) override { fault.sequence = ++number_; }
  bool reopen() override { return false; }
  void sync() const override {}
  [[nodiscard]] const std::vector<model::Fault>& events() const noexcept override { return none_; }
  [[nodiscard]] std::uint64_t overwritten() const noexcept override { return number_; }
  [[nodiscard]] std::uint64_t damaged() const noexcept override { return 0; }
  [[nodiscard]] const Problems& problems() const noexcept override { return no_problems_; }
  [[nodiscard]] const std::string& file() const noexcept override { return no_file_; }

 private:
  std::uint64_t number_ = 0;
  const std::vector<model::Fault> none_{};
  const Problems no_problems_{};
  const std::string no_file_{};
};

}  // namespace

Node::Node(const World& world, std::uint32_t index)
    : world_(world),
      index_(index),
      draws_(world.seed, "node of " + world.cell.devices[index].name),
      heard_(world.cell.devices.size()),
      agent_(make_agent()) {
  world_.kernel.at(now(), [this] { step_regularly(); });
  world_.kernel.at(now() + draws_.between(Nanoseconds{0}, kBeatEvery), [this] { beat_regularly(); });
}

Node::~Node() = default;

std::unique_ptr<agent::Agent> Node::make_agent() {
  agent::Publisher& publisher = *this;
  return std::make_unique<agent::Agent>(
      agent::Agent::Options{
          .device = name(),
          .node = id_of(name()),
          .cell = world_.cell.security_required ? world_.cell.name : "",
          .record = std::make_shared<FaultMemory>(),
          .log = [](const std::string&) {},
          .now = [this] { return now(); },
          .wall_ns = [this] { return wall_of(now()); },
          .instant_of_wall = [this](std::int64_t ns) { return from_ns(ns - wall_offset_.count()); }},
      agent::Agent::Factories{
          .parse = [this](const std::string&, const std::string&) -> Result<model::Cell> {
            return world_.cell;
          },
          .inspect = [this](const agent::InspectionRequest&) -> Result<std::unique_ptr<agent::Inspection>> {
            const auto& ports = world_.ports[index_];
            return std::unique_ptr<agent::Inspection>{std::make_unique<Inspection>(
                agent::Inspected{.paths = std::vector<std::string>(ports.size()), .ports = ports})};
          },
          .supervise =
              [this](supervision::Supervisor::Options options) -> std::unique_ptr<supervision::Supervised> {
            device_ = std::make_unique<Device>(world_, index_, *this);
            return device_->supervise(std::move(options));
          }},
      publisher);
}

void Node::receive(const wire::WholeCommand& command) {
  agent_->receive(command);
  poke();
}

std::vector<wire::WholeReply> Node::take_replies() { return std::exchange(replies_, {}); }

void Node::end() {
  agent_->end(true);
  poke();
}

void Node::step() {
  for (std::uint32_t other = 0; other < heard_.size(); ++other) {
    Heard& heard = heard_[other];
    if (!heard.alive || now() - heard.at <= kLease) continue;
    heard.alive = false;
    agent_->others().lost(other + 1);
  }
  agent_->step();
}

void Node::step_regularly() {
  step();
  if (!ended()) world_.kernel.at(now() + kStepEvery, [this] { step_regularly(); });
}

void Node::poke() {
  if (std::exchange(poked_, true)) return;
  world_.kernel.at(now(), [this] {
    poked_ = false;
    step();
  });
}

// Calls `call` on each other node, when the message has arrived there.
template <class Call>
void Node::tell_others(bool reliable, const Call& call) {
  for (std::uint32_t other = 0; other < heard_.size(); ++other) {
    if (other == index_) continue;
    world_.network->tell(index_, other, reliable, [call, &node = *(*world_.nodes)[other]] {
      call(node);
      node.poke();
    });
  }
}

void Node::publish(const LifecycleStatus& status) {
  tell_others(true, [status](Node& node) { node.agent_->others().receive(status); });
}

void Node::withdraw(const std::vector<LifecycleStatus>& modules, const supervision::Measures&) {
  tell_others(true, [modules](Node& node) {
    for (const LifecycleStatus& module : modules) node.agent_->others().remove(module);
  });
}

void Node::publish(const DeviceStatus& status) {
  status_ = status;
  world_.kernel.at(now(), [this] { beat(); });
}

// Publishes the status, with the answers to the newest statuses of the other nodes.
void Node::beat() {
  DeviceStatus status = status_;
  status.sequence_number(++sequence_);
  status.time_ns(wall_of(now()));
  status.monotonic_ns(to_ns(now()));
  for (std::uint32_t other = 0; other < heard_.size() && status.echoes().size() < 8; ++other) {
    if (std::exchange(heard_[other].answered, true)) continue;
    StatusEcho& echo = status.echoes().emplace_back();
    wire::set(echo.node(), id_of(world_.cell.devices[other].name));
    echo.monotonic_ns(heard_[other].monotonic_ns);
    echo.held_ns((now() - heard_[other].at).count());
  }
  agent_->receive(status, index_ + 1, now());
  tell_others(false, [status, from = index_](Node& node) { node.hear(status, from); });
}

void Node::beat_regularly() {
  if (status_.device().size() != 0) beat();
  world_.kernel.at(now() + kBeatEvery, [this] { beat_regularly(); });
}

void Node::hear(const DeviceStatus& status, std::uint32_t from) {
  heard_[from] = {.at = now(), .alive = true, .answered = false, .monotonic_ns = status.monotonic_ns()};
  agent_->receive(status, from + 1, now());
}

}  // namespace takt::simulation
