#include "node.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>
#include "network.hpp"
#include "operator.hpp"
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

/// The time that the disk of a device takes to write a deployment.
constexpr Nanoseconds kDiskShortest = milliseconds{1};
constexpr Nanoseconds kDiskLongest = milliseconds{30};

/// The inspection of components that are not there: it only returns the known ports.
class Inspection final : public agent::Inspection {
 public:
  explicit Inspection(agent::Inspected found) : found_(std::move(found)) {}
  std::optional<Result<agent::Inspected>> result() override { return found_; }

 private:
  agent::Inspected found_;
};

/// Returns the description of components that declare each property that the descriptor gives to a thread
/// module.
std::string declared(const model::Device& device) {
  auto modules = nlohmann::ordered_json::array();
  for (const model::Module& module : device.modules) {
    auto properties = nlohmann::ordered_json::array();
    if (module.type == model::ModuleType::thread) {
      for (const auto& given : module.properties) properties.push_back({{"name", given.name}});
    }
    modules.push_back({{"name", module.name}, {"properties", properties}});
  }
  return model::json_text({{"modules", modules}});
}

/// A fault record that ends with the simulation. The trace shows the events.
class FaultMemory final : public agent::FaultMemory {
 public:
  void append(model::Fault& fault) override { fault.sequence = ++number_; }
  void keep(std::vector<std::uint64_t>) override {}
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

/// The disk of a device. It keeps what was written when the device loses its power.
class Disk final : public agent::DeploymentStore {
 public:
  Disk(Kernel& kernel, std::uint64_t seed, const std::string& whose) : kernel_(kernel), draws_(seed, whose) {}

  void save(const agent::Kept& kept, const std::vector<std::string>& undeployed) override {
    write();
    next_ = Content{kept, undeployed};
    written_at_ = kernel_.now() + draws_.between(kDiskShortest, kDiskLongest);
  }
  [[nodiscard]] std::optional<Result<void>> saved() const override {
    write();
    if (next_) return std::nullopt;
    return Result<void>{};
  }
  [[nodiscard]] Result<agent::Kept> kept() const override { return content_.kept; }
  [[nodiscard]] Result<std::vector<std::string>> undeployed() const override { return content_.undeployed; }
  /// The device loses its power, and with it a write in progress.
  void lose() {
    write();
    next_.reset();
  }

 private:
  struct Content {
    agent::Kept kept{};
    std::vector<std::string> undeployed{};
  };
  void write() const {
    if (next_ && kernel_.now() >= written_at_) content_ = *std::exchange(next_, std::nullopt);
  }

  Kernel& kernel_;
  Draws draws_;
  Instant written_at_{};
  mutable std::optional<Content> next_{};
  mutable Content content_{};
};

Node::Node(const World& world, std::uint32_t device, std::uint32_t address)
    : world_(world),
      index_(device),
      address_(address),
      draws_(world.seed, "node " + std::to_string(address)),
      disk_(std::make_shared<Disk>(world.kernel, world.seed, "disk " + std::to_string(address))) {
  start(false);
  world_.kernel.at(now(), [this] { step_regularly(); });
  world_.kernel.at(now() + draws_.between(Nanoseconds{0}, kBeatEvery), [this] { beat_regularly(); });
}

Node::~Node() = default;

std::string Node::id() const {
  return "node " + std::to_string(address_) + " of " + name() + ", start " + std::to_string(starts_);
}

void Node::start(bool resume) {
  ++starts_;
  agent_ = make_agent();
  if (resume) agent_->resume();
}

std::unique_ptr<agent::Agent> Node::make_agent() {
  agent::Publisher& publisher = *this;
  return std::make_unique<agent::Agent>(
      agent::Agent::Options{
          .device = name(),
          .node = id(),
          .cell = world_.cell().security_required ? world_.cell().name : "",
          .host_name = "machine " + std::to_string(address_),
          .process_id = static_cast<int>(address_) + 1,
          .store = disk_,
          .boot = std::to_string(starts_),
          .record = std::make_shared<FaultMemory>(),
          .log = [](const std::string&) {},
          .now = [this] { return now(); },
          .wall_ns = [this] { return wall_of(now()); },
          .instant_of_wall = [this](std::int64_t ns) { return from_ns(ns - wall_offset_.count()); }},
      agent::Agent::Factories{
          .parse = [this](const std::string&, const std::string& file) -> Result<model::Cell> {
            for (const SimulatedCell& version : world_.versions) {
              if (version.cell.file == file) return version.cell;
            }
            return fail("there is no descriptor " + file);
          },
          .inspect =
              [this](const agent::InspectionRequest& request) -> Result<std::unique_ptr<agent::Inspection>> {
            agent::Inspected found;
            for (const SimulatedCell& version : world_.versions) {
              if (version.cell.file != request.file) continue;
              found.ports = version.ports[index_];
              for (const model::Module& module : version.cell.devices[index_].modules)
                found.paths.push_back(module.filename);
              if (request.describe) found.description = declared(version.cell.devices[index_]);
            }
            return std::unique_ptr<agent::Inspection>{std::make_unique<Inspection>(std::move(found))};
          },
          .supervise =
              [this](supervision::Supervisor::Options options) -> std::shared_ptr<supervision::Supervised> {
            const auto life = static_cast<std::uint32_t>(devices_.size());
            devices_.push_back(std::make_unique<Device>(world_, index_, *this, life));
            return devices_.back()->supervise(std::move(options));
          }},
      publisher);
}

void Node::deliver(const std::function<void()>& call) {
  if (is_down()) return;
  if (!is_paused()) return call();
  world_.kernel.at(paused_until_, [this, call, start = starts_] {
    if (start == starts_) deliver(call);
  });
}

void Node::receive(const wire::WholeCommand& command) {
  if (command.head.node().size() != 0 && command.head.node() != id()) return;
  agent_->receive(command);
  poke();
}

void Node::end() {
  ending_ = true;
  paused_until_ = {};
  if (!is_down()) agent_->end(true);
  poke();
}

void Node::go_down(Nanoseconds lasts) {
  if (is_down()) return;
  paused_until_ = {};
  if (Device* const now_running = device(); now_running != nullptr) now_running->lose_power();
  agent_.reset();
  disk_->lose();
  heard_.clear();
  modules_.clear();
  status_ = {};
  world_.kernel.at(now() + lasts, [this] {
    if (!ending_) start(true);
  });
}

void Node::pause(Nanoseconds lasts) { paused_until_ = std::max(paused_until_, now() + lasts); }

void Node::step() {
  if (is_down() || is_paused()) return;
  for (auto& [writer, heard] : heard_) {
    if (!heard.alive || now() - heard.at <= kLease) continue;
    heard.alive = false;
    agent_->others().lost(writer);
  }
  agent_->step();
}

void Node::step_regularly() {
  step();
  world_.kernel.at(now() + kStepEvery, [this] { step_regularly(); });
}

void Node::poke() {
  if (std::exchange(poked_, true)) return;
  world_.kernel.at(now(), [this] {
    poked_ = false;
    step();
  });
}

void Node::tell(std::uint32_t other, bool reliable, const std::function<void(Node&)>& call) {
  world_.network->tell(address_, other, reliable, [call, &node = *(*world_.nodes)[other]] {
    node.deliver([call, &node] {
      call(node);
      node.poke();
    });
  });
}

void Node::tell_others(bool reliable, const std::function<void(Node&)>& call) {
  for (std::uint32_t other = 0; other < world_.nodes->size(); ++other) {
    if (other != address_) tell(other, reliable, call);
  }
}

void Node::reply(const wire::WholeReply& reply) {
  world_.network->tell(address_, Network::kOperator, true,
                       [reply, &to = *world_.operator_] { to.receive(reply); });
}

void Node::publish(const LifecycleStatus& status) {
  modules_[status.path().to_string()] = status;
  tell_others(true, [status](Node& node) { node.agent_->others().receive(status); });
}

void Node::withdraw(const std::vector<LifecycleStatus>& modules, const supervision::Measures&) {
  for (const LifecycleStatus& module : modules) modules_.erase(module.path().to_string());
  tell_others(true, [modules](Node& node) {
    for (const LifecycleStatus& module : modules) node.agent_->others().remove(module);
  });
}

void Node::publish(const DeviceStatus& status) {
  status_ = status;
  world_.listener.on_status(index_, status);
  world_.kernel.at(now(), [this] { beat(); });
}

// Publishes the status, with the answers to the newest statuses of the other nodes.
void Node::beat() {
  if (is_down() || is_paused() || status_.device().size() == 0) return;
  DeviceStatus status = status_;
  status.sequence_number(++sequence_);
  status.time_ns(wall_of(now()));
  status.monotonic_ns(to_ns(now()));
  for (auto& [writer, heard] : heard_) {
    if (status.echoes().size() == 8) break;
    if (std::exchange(heard.answered, true)) continue;
    StatusEcho& echo = status.echoes().emplace_back();
    wire::set(echo.node(), heard.node);
    echo.monotonic_ns(heard.monotonic_ns);
    echo.held_ns((now() - heard.at).count());
  }
  agent_->receive(status, writer(), now());
  tell_others(false, [status, from = address_, by = writer()](Node& node) { node.hear(status, from, by); });
  world_.network->tell(address_, Network::kOperator, false,
                       [status, &to = *world_.operator_] { to.hear(status); });
}

void Node::beat_regularly() {
  beat();
  world_.kernel.at(now() + kBeatEvery, [this] { beat_regularly(); });
}

void Node::hear(const DeviceStatus& status, std::uint32_t from, wire::WriterId writer) {
  // A node gives the states of its modules to each node that it finds.
  if (heard_.count(writer) == 0) {
    for (const auto& [path, module] : modules_)
      tell(from, true, [state = module](Node& node) { node.agent_->others().receive(state); });
  }
  heard_[writer] = {.node = status.node().to_string(),
                    .at = now(),
                    .alive = true,
                    .answered = false,
                    .monotonic_ns = status.monotonic_ns()};
  agent_->receive(status, writer, now());
}

}  // namespace takt::simulation
