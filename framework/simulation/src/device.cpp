// Sets up a simulated device, and makes its report.
#include "device.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "member.hpp"
#include "network.hpp"

namespace takt::simulation {

namespace {

using json = nlohmann::ordered_json;

/// Programs have this much less priority than the executors with which they share a CPU.
constexpr int kProgramBelow = 2;

}  // namespace

Device::Device(const World& world, std::uint32_t index)
    : world_(world), index_(index), draws_(world.seed, world.cell.devices[index].name) {}

Device::~Device() = default;

Result<void> Device::prepare() {
  std::vector<std::string> executors;
  std::vector<std::string> modules;
  for (const auto& executor : model().executors) executors.push_back(executor.name);
  for (const auto& module : model().modules) modules.push_back(module.name);
  auto channel = channel::Channel::create(1, executors, modules);
  if (!channel) return channel.problems();
  channel_ = std::move(*channel);
  wake_word_ = std::make_unique<channel::WakeWord>();
  wake_word_->gateway_sleeps.store(1);

  make_members();
  make_wires();
  start_host();
  for (auto& member : members_) {
    if (member->is_thread()) continue;
    if (member->scheduled())
      spawn(*member);
    else
      apply(*member, lifecycle::Event::initialize);
  }
  step();
  return {};
}

void Device::make_members() {
  for (std::uint32_t i = 0; i < model().modules.size(); ++i) {
    members_.push_back(std::make_unique<Member>(*this, world_, model(), i, channel_.module(i)));
    Member& member = *members_.back();
    for (std::uint32_t e = 0; e < model().executors.size(); ++e) {
      if (model().executors[e].name == member.model.executor) member.executor = e;
    }
    if (member.is_thread() || !member.scheduled()) continue;
    member.slot = std::make_unique<channel::ReleaseSlot>();
    channel::ReleaseSlot& slot = *member.slot;
    slot.magic = channel::ReleaseSlot::kMagic;
    slot.name.assign(member.model.name);
    slot.kind = member.sporadic() ? channel::ReleaseSlotKind::sporadic : channel::ReleaseSlotKind::periodic;
    slot.wake_bit = channel::wake_bit(i);
    slot.period_ns = member.sporadic() ? world_.plans[index_].executors[member.executor].basic_period.count()
                                       : member.model.period->count();
    slot.margin_cap_ns = std::min<std::int64_t>(slot.period_ns / 10, 100'000);
    slot.deadline_ns = member.model.deadline.value_or(Nanoseconds{0}).count();
    slot.immediate = member.model.dispatch == model::Dispatch::immediate ? 1 : 0;
    slot.interarrival_ns = member.model.interarrival.value_or(Nanoseconds{0}).count();
    if (!member.sporadic()) {
      slot.offset_ns = schedule::offset_of(world_.plans[index_].executors[member.executor], i).count();
      slot.logical = member.logical ? 1 : 0;
      if (member.contract.what == model::Overrun::catch_up)
        slot.catch_up = static_cast<std::uint32_t>(member.contract.limit);
    }
  }
}

void Device::make_wires() {
  const auto here = [this](const model::Endpoint& end) -> Wire::End {
    if (end.device != model().name) return std::nullopt;
    for (const auto& member : members_) {
      if (member->model.name == end.module) return member->index;
    }
    return std::nullopt;
  };
  const auto is_event = [this](const Member& member, const std::string& port) {
    if (index_ < world_.ports.size() && member.index < world_.ports[index_].size()) {
      if (const model::ModulePorts& ports = world_.ports[index_][member.index]) {
        return std::any_of(ports->begin(), ports->end(), [&port](const model::Port& p) {
          return p.name == port && p.direction == model::Direction::event;
        });
      }
    }
    return member.sporadic();  // its ports are unknown: every input is an event
  };
  for (std::uint32_t i = 0; i < world_.cell.connections.size(); ++i) {
    const model::Connection& connection = world_.cell.connections[i];
    const Wire::End from = here(connection.from);
    const Wire::End to = here(connection.to);
    std::uint32_t wakes = 0;
    if (to && members_[*to]->model.dispatch == model::Dispatch::immediate &&
        is_event(*members_[*to], connection.to.port)) {
      wakes = members_[*to]->is_thread() ? channel::kSporadicBit : channel::wake_bit(*to);
    }
    const auto add = [&](Wire::End writer, Wire::End reader, std::uint32_t wake_bits) {
      const std::uint64_t ahead = writer
                                      ? schedule::samples_ahead(model(), members_[*writer]->model,
                                                                reader ? &members_[*reader]->model : nullptr)
                                      : 0;
      wires_.push_back(std::make_unique<Wire>(connection, i, writer, reader, wake_bits, ahead));
      Wire& wire = *wires_.back();
      if (reader)
        members_[*reader]->inputs.push_back({&wire, is_event(*members_[*reader], connection.to.port)});
      if (writer) members_[*writer]->outputs.push_back({&wire});
      return &wire;
    };
    if (from && to && connection.topic.empty()) {
      add(from, to, wakes);
      continue;
    }
    if (from) add(from, std::nullopt, channel::kGatewayBit);
    if (to) {
      Wire* const wire = add(std::nullopt, to, wakes);
      if (connection.from.given()) world_.network->connect(i, *this, *wire);
    }
  }
}

executor::Unit Device::unit_of(Member& member) const {
  const model::Module& m = member.model;
  return {.index = member.index,
          .body = member.is_thread() ? &member.body : nullptr,
          .slot = member.slot.get(),
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

void Device::make_executors() {
  rows_.clear();
  const schedule::DevicePlan& plan = world_.plans[index_];
  for (std::uint32_t e = 0; e < plan.executors.size(); ++e) {
    const schedule::ExecutorPlan& mine = plan.executors[e];
    const auto units = [this](const std::vector<std::uint32_t>& indices) {
      std::vector<executor::Unit> selected;
      for (const std::uint32_t i : indices) selected.push_back(unit_of(*members_[i]));
      return selected;
    };
    const std::string whose = model().name + " " + model().executors[e].name + " " + std::to_string(host_);
    rows_.push_back(std::unique_ptr<Row>(new Row{
        .plan = mine,
        .index = e,
        .draws = Draws{world_.seed, whose},
        .executor = std::make_unique<executor::Executor>(mine, units(mine.periodic), units(mine.sporadic),
                                                         channel_.executor(e), world_.kernel),
    }));
    std::vector<std::uint32_t>& programs = rows_.back()->in_priority;
    for (const auto* list : {&mine.periodic, &mine.sporadic}) {
      for (const std::uint32_t i : *list) {
        if (members_[i]->is_process()) programs.push_back(i);
      }
    }
    std::stable_sort(programs.begin(),
                     programs.begin() + static_cast<std::ptrdiff_t>(std::count_if(
                                            mine.periodic.begin(), mine.periodic.end(),
                                            [this](std::uint32_t i) { return members_[i]->is_process(); })),
                     [this](std::uint32_t a, std::uint32_t b) {
                       return members_[a]->model.priority < members_[b]->model.priority;
                     });
  }
}

// Executors that name the same CPU share it. Those that name none have one each, or share the CPUs of the
// device.
Kernel::Place Device::place_of(std::uint32_t executor, std::optional<int> wanted, std::size_t index,
                               int below) {
  const int priority = world_.plans[index_].executors[executor].priority - below;
  if (world_.cpus == 0 && !wanted) return {.cpu = nullptr, .priority = priority};
  int cpu = wanted.value_or(static_cast<int>(index));
  if (world_.cpus != 0) cpu %= world_.cpus;
  return {.cpu = &shared_cpus_[cpu], .priority = priority};
}

// Programs avoid the CPUs of executors if the device has others.
Kernel::Place Device::place_of(const Member& member) {
  if (!member.scheduled()) return {.cpu = nullptr, .priority = 0};
  return place_of(member.executor, std::nullopt, member.index, kProgramBelow);
}

void Device::emit(Event event) {
  event.at = now();
  event.device = index_;
  world_.listener.on_event(event);
}

void Device::emit(Event event, const Member& member) {
  event.module = member.index;
  emit(event);
}

void Device::emit(What what, const Member& member) { emit({.what = what}, member); }

// Includes the releases that a program with immediate dispatch gave itself.
std::uint64_t Device::cycles(const Member& member) {
  return member.block.cycles.load() + (member.slot ? member.slot->begun.load() : 0);
}

Totals Device::totals() const {
  Totals totals;
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    const channel::ExecutorBlock& block = channel_.executor(e);
    totals.executors.push_back({block.cycles.load(), block.missed.load(), block.next_row.load()});
  }
  for (const auto& member : members_) {
    const channel::ModuleBlock& block = member->block;
    totals.modules.push_back({.cycles = cycles(*member),
                              .missed = block.missed.load(),
                              .overruns = block.overruns.load(),
                              .state = member->state(),
                              .steps = member->machine.sequence()});
  }
  for (const auto& wire : wires_) {
    if (!wire->adds_up()) totals.unbalanced.push_back(wire->connection());
  }
  return totals;
}

namespace {

json in_microseconds(const StatisticsSnapshot& s) {
  const auto us = [](auto ns) { return static_cast<double>(ns) / 1e3; };
  return {{"mean", us(s.mean)},
          {"variance", s.variance / 1e6},
          {"min", us(s.min)},
          {"p50", us(s.quantile(0.5))},
          {"p99", us(s.quantile(0.99))},
          {"p999", us(s.quantile(0.999))},
          {"max", us(s.max)}};
}

}  // namespace

json Device::report() const {
  json executors = json::array();
  for (std::size_t e = 0; e < channel_.executors(); ++e) {
    const channel::ExecutorBlock& block = channel_.executor(e);
    executors.push_back({{"name", model().executors[e].name},
                         {"cycles", block.cycles.load()},
                         {"missed", block.missed.load()},
                         {"jitter_us", in_microseconds(block.jitter.read())}});
  }
  json modules = json::array();
  for (const auto& member : members_) {
    const channel::ModuleBlock& block = member->block;
    const channel::ReleaseSlot* slot = member->slot.get();
    modules.push_back({{"name", member->model.name},
                       {"type", model::to_text(member->model.type)},
                       {"operation", model::to_text(member->model.operation)},
                       {"state", lifecycle::to_text(member->state())},
                       {"cycles", cycles(*member)},
                       {"overruns", block.overruns.load() + (slot == nullptr ? 0 : slot->late.load())},
                       {"errors", block.errors.load() + member->errors},
                       {"jitter_us", in_microseconds((slot == nullptr ? block.jitter : slot->jitter).read())},
                       {"run_us", in_microseconds((slot == nullptr ? block.run : slot->run).read())},
                       {"pid", 0}});
    if (member->failed && !member->why.empty()) modules.back()["text"] = member->why;
    if (member->inputs.empty() && member->outputs.empty()) continue;
    // One entry per port; a port may have several connections.
    struct Health {
      std::string name;
      const char* direction;
      std::uint64_t connections = 0, samples = 0, lost = 0, dropped = 0, late = 0;
      std::int64_t newest = 0;
    };
    std::vector<Health> ports;
    const auto of = [&ports](const std::string& name, const char* direction) -> Health& {
      for (Health& port : ports) {
        if (port.name == name) return port;
      }
      return ports.emplace_back(Health{.name = name, .direction = direction});
    };
    for (const auto& input : member->inputs) {
      const Wire& wire = *input.wire;
      const channel::LinkBlock& link = wire.link().block();
      Health& port = of(wire.model().to.port, input.event ? "event" : "in");
      ++port.connections;
      port.samples += link.taken.load();
      port.lost += wire.writer() ? 0 : world_.network->lost(wire.connection());
      port.dropped += link.is_queue != 0 ? link.overwritten.load() : 0;
      port.late += link.late.load();
      port.newest = std::max(port.newest, link.newest_ns.load());
    }
    for (const auto& output : member->outputs) {
      const Wire& wire = *output.wire;
      const channel::LinkBlock& link = wire.link().block();
      Health& port = of(wire.model().from.port, "out");
      ++port.connections;
      port.samples = std::max(port.samples, link.written.load());
      port.lost += wire.reader() ? 0 : world_.network->lost(wire.connection());
      port.dropped += wire.reader() && link.is_queue != 0 ? link.overwritten.load() : 0;
      port.newest = std::max(port.newest, link.newest_ns.load());
    }
    json& list = modules.back()["ports"] = json::array();
    for (const Health& port : ports) {
      const double age = static_cast<double>(to_ns(world_.kernel.now()) - port.newest) / 1e3;
      list.push_back({{"name", port.name},
                      {"direction", port.direction},
                      {"type", nullptr},
                      {"connections", port.connections},
                      {"matched", port.connections},
                      {"samples", port.samples},
                      {"lost", port.lost},
                      {"dropped", port.dropped},
                      {"refused", 0},
                      {"late", port.late},
                      {"age_us", port.newest == 0 ? json(nullptr) : json(age)},
                      {"incompatible", nullptr}});
    }
  }
  return {{"name", model().name},
          {"alive", true},
          {"real_time", true},
          {"executors", executors},
          {"modules", modules}};
}

}  // namespace takt::simulation
