// Sets up a simulated device.
#include "device.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/check.hpp>
#include "member.hpp"
#include "network.hpp"
#include "node.hpp"
#include "virtual_platform.hpp"

namespace takt::simulation {

namespace {

/// The priority of a process module is lower by this number than the priority of its executor.
constexpr int kProgramBelow = 2;

}  // namespace

Device::Device(const World& world, std::uint32_t index, Node& node, std::uint32_t life)
    : world_(world),
      index_(index),
      draws_(world.seed, world.cell().devices[index].name),
      node_(node),
      life_(life) {}

Device::~Device() = default;

std::shared_ptr<supervision::Supervised> Device::supervise(supervision::Supervisor::Options options) {
  const auto same_file = [&options](const SimulatedCell& one) { return one.cell.file == options.cell.file; };
  const auto& all = world_.versions;
  version_ = static_cast<std::uint32_t>(std::find_if(all.begin(), all.end(), same_file) - all.begin());
  supervisor_ =
      std::make_shared<supervision::Supervisor>(std::move(options), std::make_shared<VirtualPlatform>(*this));
  return supervisor_;
}

void Device::lose_power() {
  last_report_ = supervisor_->report();  // the supervision asks the agent, which ends now
  has_lost_power_ = true;
  world_.network->disconnect(*this);
  for (const Row* row : rows_) {
    if (row != nullptr) row->host.kill();
  }
  for (const auto& member : members_) {
    if (member->host != nullptr) member->host->kill();
    if (member->process != nullptr) member->process->kill();
  }
}

void Device::begin(supervision::Parts& parts) {
  parts_ = &parts;
  emit({.what = What::prepares});
  // The placement has enough CPUs that each process module has its own CPU for spinning.
  for (int i = 0; i <= static_cast<int>(model().modules.size()); ++i) parts.placement.background.push_back(i);
  parts.placement.executors.resize(model().executors.size());
  wake_word().gateway_sleeps.store(1);
  rows_.resize(model().executors.size());
  for (std::uint32_t i = 0; i < model().modules.size(); ++i)
    members_.push_back(std::make_unique<Member>(*this, world_, parts, i));
  make_links();
}

// Makes the simulated links of the device's connections. The wiring contains the links in the order of the
// connections. A connection over a topic within the device has two links. The links for observers come last;
// the simulation does not use them.
void Device::make_links() {
  const auto& planned = parts_->wiring.links();
  const auto add = [&](std::uint32_t index) {
    TAKT_CHECK(links_.size() < planned.size());
    const supervision::Wiring::CreatedLink& created = planned[links_.size()];
    const model::Connection& connection = cell().connections[index];
    links_.push_back(
        std::make_unique<SimulatedLink>(connection, index, world_.versions[version_].numbers[index],
                                        created.plan.from.module, created.plan.to.module, created.link));
    SimulatedLink& link = *links_.back();
    if (link.reader()) {
      const model::Port* port = model::find_port(cell(), world_.versions[version_].ports, connection.to);
      members_[*link.reader()]->inputs.push_back({&link, port->direction == model::Direction::event});
    }
    if (link.writer()) members_[*link.writer()]->outputs.push_back({&link});
    return &link;
  };
  for (std::uint32_t i = 0; i < cell().connections.size(); ++i) {
    const model::Connection& connection = cell().connections[i];
    const bool from = connection.from.given() && connection.from.device == model().name;
    const bool to = connection.to.given() && connection.to.device == model().name;
    if (from) add(i);
    if (!to || connection.topic.empty()) continue;
    SimulatedLink* const link = add(i);
    if (connection.from.given()) world_.network->connect(*this, *link);
  }
}

void Device::poke() { node_.poke(); }

executor::Unit Device::unit_of(Member& member) const {
  const model::Module& m = member.model;
  return {.index = member.index,
          .body = member.is_thread() ? &member.body : nullptr,
          .slot = member.slot,
          .block = &member.block,
          .period = m.period.value_or(Nanoseconds{0}),
          .deadline = m.deadline.value_or(Nanoseconds{0}),
          .budget = m.budget.value_or(Nanoseconds{0}),
          .interarrival = m.interarrival.value_or(Nanoseconds{0}),
          .immediate = m.dispatch == model::Dispatch::immediate,
          .late_is_error = m.miss == model::Miss::error,
          .overrun = member.contract,
          .tolerance = m.tolerance};
}

std::unique_ptr<Device::Row> Device::make_row(std::uint32_t executor, VirtualHost& host,
                                              std::uint64_t generation) {
  const schedule::ExecutorPlan& plan = parts_->plan.executors[executor];
  const auto units = [this](const std::vector<std::uint32_t>& indices) {
    std::vector<executor::Unit> selected;
    for (const std::uint32_t i : indices) selected.push_back(unit_of(*members_[i]));
    return selected;
  };
  const std::string whose =
      model().name + " " + model().executors[executor].name + " " + std::to_string(generation);
  auto row = std::unique_ptr<Row>(new Row{
      .plan = plan,
      .index = executor,
      .host = host,
      .draws = Draws{world_.seed, whose},
      .executor = std::make_unique<executor::Executor>(plan, units(plan.periodic), units(plan.sporadic),
                                                       parts_->channel.executor(executor), world_.kernel),
  });
  const auto is_program = [this](std::uint32_t i) { return !members_[i]->is_thread(); };
  for (const auto* list : {&plan.periodic, &plan.sporadic})
    std::copy_if(list->begin(), list->end(), std::back_inserter(row->in_priority), is_program);
  std::stable_sort(
      row->in_priority.begin(),
      row->in_priority.begin() + std::count_if(plan.periodic.begin(), plan.periodic.end(), is_program),
      [this](std::uint32_t a, std::uint32_t b) {
        return members_[a]->model.priority < members_[b]->model.priority;
      });
  return row;
}

// Executors that name the same CPU share it. Executors that name no CPU have one CPU each, or share the
// `cpus` CPUs of the device if this option is set.
Kernel::Scheduling Device::scheduling_of(std::uint32_t executor, std::optional<int> wanted, std::size_t index,
                                         int below) {
  const int priority = parts_->plan.executors[executor].priority - below;
  if (world_.cpus == 0 && !wanted) return {.cpu = nullptr, .priority = priority};
  int cpu = wanted.value_or(static_cast<int>(index));
  if (world_.cpus != 0) cpu %= world_.cpus;
  return {.cpu = &shared_cpus_[cpu], .priority = priority};
}

// A process module has its own CPU. If the option `cpus` is set, a real-time process module shares these CPUs
// with the executors.
Kernel::Scheduling Device::scheduling_of(const Member& member) {
  if (!member.scheduled()) return {.cpu = nullptr, .priority = 0};
  return scheduling_of(member.executor, std::nullopt, member.index, kProgramBelow);
}

void Device::emit(Event event) {
  event.at = now();
  event.device = index_;
  event.version = version_;
  world_.listener.on_event(event);
}

void Device::emit(Event event, const Member& member) {
  event.module = member.index;
  emit(event);
}

void Device::emit(What what, const Member& member) { emit({.what = what}, member); }

// Returns the number of calls or releases of a module. This includes the releases that a process module with
// immediate dispatch gave itself.
std::uint64_t Device::cycles(const Member& member) {
  return member.block.cycles.load() + (member.slot == nullptr ? 0 : member.slot->begun.load());
}

Totals Device::totals() const {
  Totals totals;
  for (std::size_t e = 0; e < parts_->channel.executors(); ++e) {
    const channel::ExecutorBlock& block = parts_->channel.executor(e);
    totals.executors.push_back({block.cycles.load(), block.missed.load(), block.next_row.load()});
  }
  for (const auto& member : members_) {
    const channel::ModuleBlock& block = member->block;
    const lifecycle::Machine& machine = supervisor_->machine(member->index);
    totals.modules.push_back({.cycles = cycles(*member),
                              .missed = block.missed.load(),
                              .overruns = block.overruns.load(),
                              .state = machine.state(),
                              .steps = machine.sequence()});
  }
  for (const auto& link : links_) {
    if (!link->adds_up()) totals.unbalanced.push_back(link->connection());
  }
  return totals;
}

nlohmann::ordered_json Device::report() const {
  return has_lost_power_ ? last_report_ : supervisor_->report();
}

}  // namespace takt::simulation
