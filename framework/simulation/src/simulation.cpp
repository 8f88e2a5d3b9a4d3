#include <takt/simulation/simulation.hpp>

#include <algorithm>
#include <memory>

#include <takt/core/check.hpp>
#include <takt/model/json.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/words.hpp>
#include "invariants.hpp"
#include "network.hpp"
#include "node.hpp"
#include "simulated_cell.hpp"

namespace takt::simulation {

namespace {

/// The time before T0 in which the cell is deployed: the nodes find each other, compare their clocks, and
/// initialise and start the modules.
constexpr Nanoseconds kLead = std::chrono::milliseconds{900};
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

 private:
  Listener& first_;
  Listener* second_;
};

using Nodes = std::vector<std::unique_ptr<Node>>;

wire::WholeCommand command_of(CommandKind kind) {
  wire::WholeCommand command;
  wire::set(command.head.id(), std::string{"simulation "} + takt::to_text(kind));
  command.head.kind(kind);
  wire::set(command.head.deployment(), "simulated");
  wire::set(command.head.property(), "simulated");
  return command;
}

// Sends a command to each node, and waits for the replies.
Result<void> send_all(Kernel& kernel, const Nodes& nodes, const wire::WholeCommand& command) {
  for (const auto& node : nodes) node->receive(command);
  std::size_t replied = 0;
  while (replied < nodes.size()) {
    TAKT_CHECK(kernel.now() < kT0);
    kernel.run_until(kernel.now() + kLook);
    for (const auto& node : nodes) {
      for (const wire::WholeReply& reply : node->take_replies()) {
        if (reply.head.code() != REPLY_OK) return fail(reply.head.text().to_string());
        ++replied;
      }
    }
  }
  return {};
}

// Deploys the cell on all nodes, as `takt deploy` does. The cell begins at kT0.
Result<void> deploy(Kernel& kernel, const World& world, const Nodes& nodes) {
  if (auto prepared = send_all(kernel, nodes, command_of(COMMAND_PREPARE)); !prepared) return prepared;
  wire::WholeCommand change = command_of(COMMAND_CHANGE);
  change.data = model::json_text(
      {{"devices", model::device_names(world.cell)},
       {"safe", model::parse_json(model::safe_json(model::safe_outputs(world.cell, world.ports)))}});
  if (auto changed = send_all(kernel, nodes, change); !changed) return changed;
  wire::WholeCommand run = command_of(COMMAND_RUN);
  run.head.time_ns(to_ns(kT0));
  return send_all(kernel, nodes, run);
}

}  // namespace

Result<Course> simulate(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                        const model::CellPorts& ports, const Options& options) {
  Kernel kernel{kT0 - kLead};
  Invariants invariants{cell, plans, kT0};
  Both listener{invariants, options.listener};
  const SimulatedCell simulated = simulated_cell(cell, ports);
  World world{.kernel = kernel,
              .listener = listener,
              .cell = simulated.cell,
              .ports = simulated.ports,
              .profile = options.profile,
              .seed = options.seed,
              .cpus = options.cpus};
  Network network{world};
  world.network = &network;

  Nodes nodes;
  world.nodes = &nodes;
  for (std::uint32_t i = 0; i < cell.devices.size(); ++i) nodes.push_back(std::make_unique<Node>(world, i));
  if (auto deployed = deploy(kernel, world, nodes); !deployed) return deployed.problems();

  Draws draws{options.seed, "faults"};
  std::vector<Injection> injections = draw_injections(cell, draws, options.length, options.faults_per_second);
  injections.insert(injections.end(), options.injections.begin(), options.injections.end());
  for (const Injection& injection : injections) {
    if (injection.at < options.length)
      kernel.at(kT0 + injection.at,
                [&nodes, injection] { nodes[injection.device]->device()->inject(injection); });
  }
  constexpr std::int64_t kSteps = 500;
  for (std::int64_t i = 1; options.progress && i < kSteps; ++i) {
    const Nanoseconds passed = options.length / kSteps * i;
    kernel.run_until(kT0 + passed);
    options.progress(passed);
  }
  kernel.run_until(kT0 + options.length);

  for (auto& node : nodes) node->end();
  const Instant limit = kernel.now() + kEndLimit;
  while (!std::all_of(nodes.begin(), nodes.end(), [](const auto& node) { return node->ended(); })) {
    TAKT_CHECK(kernel.now() < limit);
    kernel.run_until(kernel.now() + kLook);
  }

  Course course;
  course.report = {{"cell", cell.name}, {"devices", nlohmann::ordered_json::array()}};
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const Device& device = *nodes[i]->device();
    invariants.close(i, device.totals());
    course.report["devices"].push_back(device.report());
    const Problems& failures = device.failures();
    course.failures.insert(course.failures.end(), failures.begin(), failures.end());
  }
  course.violations = invariants.violations();
  return course;
}

}  // namespace takt::simulation
