#include <takt/simulation/simulation.hpp>

#include <algorithm>
#include <memory>
#include <optional>

#include <takt/core/check.hpp>
#include <takt/model/json.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/words.hpp>
#include "invariants.hpp"
#include "network.hpp"
#include "node.hpp"
#include "operator.hpp"
#include "simulated_cell.hpp"

namespace takt::simulation {

namespace {

/// The time before T0 in which the cell is deployed: the nodes find each other, compare their clocks, and
/// initialise and start the modules.
constexpr Nanoseconds kLead = std::chrono::milliseconds{900};
/// The time after T0 in which the operator sees that the cell is deployed.
constexpr Nanoseconds kDeployed = std::chrono::milliseconds{200};
/// The maximum time that the devices may take to end. No device needs more, even if something hangs.
constexpr Nanoseconds kEndLimit = std::chrono::seconds{30};
constexpr Nanoseconds kLook = std::chrono::milliseconds{5};

class Both final : public Listener {
 public:
  Both(Listener& first, Listener* second) : first_(first), second_(second) {}
  void on_event(const Event& event) override {
    if (second_ != nullptr) second_->on_event(event);
    first_.on_event(event);
  }
  void on_status(std::uint32_t device, const DeviceStatus& status) override {
    if (second_ != nullptr) second_->on_status(device, status);
  }

 private:
  Listener& first_;
  Listener* second_;
};

using Nodes = std::vector<std::unique_ptr<Node>>;

/// Returns the index of the module, executor or connection of `to` that the injection's target is in `from`;
/// none if `to` does not have it.
std::optional<std::uint32_t> target_in(const Injection& injection, const model::Cell& from,
                                       const model::Cell& to) {
  const auto index_of = [](const auto& all, const auto& is_it) -> std::optional<std::uint32_t> {
    const auto found = std::find_if(all.begin(), all.end(), is_it);
    if (found == all.end()) return std::nullopt;
    return static_cast<std::uint32_t>(found - all.begin());
  };
  const model::Device& was = from.devices[injection.device];
  const model::Device& is = to.devices[injection.device];
  switch (target_of(injection.kind)) {
    case Injection::Target::module: {
      const std::string& name = was.modules[injection.target].name;
      return index_of(is.modules, [&name](const model::Module& one) { return one.name == name; });
    }
    case Injection::Target::executor: {
      const std::string& name = was.executors[injection.target].name;
      return index_of(is.executors, [&name](const model::Executor& one) { return one.name == name; });
    }
    case Injection::Target::connection: {
      const model::Connection& connection = from.connections[injection.target];
      return index_of(to.connections, [&connection](const model::Connection& one) {
        return one.from == connection.from && one.to == connection.to;
      });
    }
    default:
      return injection.target;
  }
}

/// Injects faults into the devices, the network and the operator, and gives the operator its orders.
class Injector {
 public:
  Injector(World& world, Nodes& nodes) : world_(world), nodes_(nodes) {}

  void inject(Injection injection) {
    const std::string text = to_text(injection, world_.cell());
    const bool of_cell =
        is_operator(injection.device) || target_of(injection.kind) == Injection::Target::cell;
    world_.listener.on_event({.at = world_.kernel.now(),
                              .what = What::fault,
                              .device = of_cell ? Event::kNone : injection.device,
                              .text = text});
    using Kind = Injection::Kind;
    switch (injection.kind) {
      case Kind::deploy:
        return world_.operator_->begin(Action::deploy);
      case Kind::update:
        return world_.operator_->begin(Action::update);
      case Kind::undeploy:
        return world_.operator_->begin(Action::undeploy);
      case Kind::cut:
        return world_.network->cut(address_of(injection.device), address_of(injection.target), injection.by);
      case Kind::down:
        return is_operator(injection.device) ? world_.operator_->go_down(injection.by)
                                             : nodes_[injection.device]->go_down(injection.by);
      case Kind::pause:
        return is_operator(injection.device) ? world_.operator_->pause(injection.by)
                                             : nodes_[injection.device]->pause(injection.by);
      case Kind::twin:
        nodes_.push_back(
            std::make_unique<Node>(world_, injection.device, static_cast<std::uint32_t>(nodes_.size())));
        return;
      case Kind::clock_step:
        return nodes_[injection.device]->set_clock(injection.by);
      default:
        break;
    }
    Device* const device = nodes_[injection.device]->device();
    const auto without_effect = [&](const char* why) {
      without_effect_.push_back("'" + text + "' has no effect: " + why);
    };
    if (device->has_lost_power() || device->phase() == Device::Phase::ended)
      return without_effect("the device runs no cell then");
    const SimulatedCell& version = world_.versions[device->version()];
    const auto target = target_in(injection, world_.cell(), version.cell);
    if (!target) return without_effect("the update has removed it");
    injection.target = *target;
    if (injection.kind == Kind::lose)
      world_.network->lose(version.numbers[*target], injection.count);
    else if (injection.kind == Kind::delay)
      world_.network->delay(version.numbers[*target], injection.by);
    else
      device->inject(injection);
  }

  /// Returns the faults that had no effect, each with the reason.
  [[nodiscard]] const std::vector<std::string>& without_effect() const noexcept { return without_effect_; }

 private:
  [[nodiscard]] bool is_operator(std::uint32_t device) const {
    return device == world_.cell().devices.size();
  }
  [[nodiscard]] std::uint32_t address_of(std::uint32_t device) const {
    return is_operator(device) ? Network::kOperator : device;
  }

  World& world_;
  Nodes& nodes_;
  std::vector<std::string> without_effect_;
};

/// Checks that an update can be simulated.
Result<void> check_update(const model::Cell& cell, const model::Cell& update) {
  if (model::device_names(cell) != model::device_names(update))
    return fail("the update has other devices than the cell",
                "simulate an update that keeps the devices and their order");
  if (cell.name != update.name)
    return fail("the update is for cell " + update.name + ", not for cell " + cell.name, "rename its cell");
  return {};
}

}  // namespace

std::string to_text(const Report& report) {
  const std::string action = report.action == Action::deploy   ? "deploy"
                             : report.action == Action::update ? "update"
                                                               : "undeploy";
  const std::string outcome = report.outcome == Outcome::done ? "done"
                              : report.outcome == Outcome::unchanged
                                  ? "failed; the devices run what they ran before"
                                  : "its outcome is not known";
  return action + ": " + outcome + (report.why.empty() ? "" : ": " + report.why);
}

Result<Course> simulate(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                        const model::CellPorts& ports, const Options& options) {
  Kernel kernel{kT0 - kLead};
  Invariants invariants{cell, plans, kT0};
  std::vector<SimulatedCell> versions{simulated_cell(cell, ports)};
  ConnectionNumbers numbers;
  versions[0].numbers = numbers.of(cell);
  if (options.update != nullptr) {
    if (auto fits = check_update(cell, options.update->cell); !fits) return fits.problems();
    invariants.add_version(options.update->cell, options.update->plans);
    versions.push_back(simulated_cell(options.update->cell, options.update->ports));
    versions[1].numbers = numbers.of(options.update->cell);
  }
  Both listener{invariants, options.listener};
  World world{.kernel = kernel,
              .listener = listener,
              .versions = versions,
              .profile = options.profile,
              .seed = options.seed,
              .cpus = options.cpus};
  Network network{world};
  world.network = &network;
  Nodes nodes;
  world.nodes = &nodes;
  Operator sender{world};
  world.operator_ = &sender;
  const auto devices = static_cast<std::uint32_t>(cell.devices.size());
  for (std::uint32_t i = 0; i < devices; ++i) nodes.push_back(std::make_unique<Node>(world, i, i));
  sender.begin_at(kT0);
  kernel.run_until(kT0 - Nanoseconds{1});
  if (!sender.reports().empty()) return fail(to_text(sender.reports().front()));

  Draws draws{options.seed, "faults"};
  std::vector<Injection> injections = draw_injections(cell, draws, options.length, options.faults_per_second);
  injections.insert(injections.end(), options.injections.begin(), options.injections.end());
  Injector injector{world, nodes};
  for (const Injection& injection : injections) {
    if (injection.at < options.length)
      kernel.at(kT0 + injection.at, [&injector, injection] { injector.inject(injection); });
  }
  kernel.at(kT0 + kDeployed, [&] { world.message_delay = options.message_delay; });
  constexpr std::int64_t kSteps = 500;
  for (std::int64_t i = 1; options.progress && i < kSteps; ++i) {
    const Nanoseconds passed = options.length / kSteps * i;
    kernel.run_until(kT0 + passed);
    options.progress(passed);
  }
  kernel.run_until(kT0 + options.length);

  Course course;
  for (std::uint32_t i = 0; i < devices; ++i) {
    const Device& device = *nodes[i]->device();
    const bool runs = !device.has_lost_power() && device.phase() == Device::Phase::running;
    course.ran.push_back(runs ? std::optional{device.version()} : std::nullopt);
  }
  const bool is_deployed = !sender.reports().empty();
  if (is_deployed) sender.end("the simulation ended before");
  course.reports = sender.reports();
  if (is_deployed) course.reports.erase(course.reports.begin());
  course.without_effect = injector.without_effect();
  for (auto& node : nodes) node->end();
  const Instant limit = kernel.now() + kEndLimit;
  while (!std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node->ended(); })) {
    TAKT_CHECK(kernel.now() < limit);
    kernel.run_until(kernel.now() + kLook);
  }

  course.report = {{"cell", cell.name}, {"devices", nlohmann::ordered_json::array()}};
  for (std::uint32_t i = 0; i < devices; ++i) {
    for (const auto& device : nodes[i]->devices()) {
      const Problems& failures = device->failures();
      course.failures.insert(course.failures.end(), failures.begin(), failures.end());
    }
    const Device& last = *nodes[i]->device();
    if (!last.has_lost_power()) invariants.close(i, last.totals());
    course.report["devices"].push_back(last.report());
  }
  course.violations = invariants.violations();
  return course;
}

}  // namespace takt::simulation
