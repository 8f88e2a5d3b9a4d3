// The supervisor's reports on its device: the status JSON, the statistics for the topics, and a summary.
#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/supervision/supervisor.hpp>
#include <takt/wire/words.hpp>
#include "forces.hpp"
#include "health.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

namespace {

using json = nlohmann::ordered_json;

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

Distribution on_the_wire(const StatisticsSnapshot& s) {
  const auto us = [](auto ns) { return static_cast<double>(ns) / 1e3; };
  Distribution d;
  d.mean(us(s.mean));
  d.variance(s.variance / 1e6);
  d.min(us(s.min));
  d.p50(us(s.quantile(0.5)));
  d.p99(us(s.quantile(0.99)));
  d.p999(us(s.quantile(0.999)));
  d.max(us(s.max));
  return d;
}

const Statistics& jitter_of(const Member& member) {
  return member.slot == nullptr ? member.block.jitter : member.slot->jitter;
}
const Statistics& run_of(const Member& member) {
  return member.slot == nullptr ? member.block.run : member.slot->run;
}
bool is_faulty(const Member& member) {
  return member.state() == lifecycle::State::recover ||
         (member.state() == lifecycle::State::destruct && member.failed);
}

json in_json(const model::Port& port, const PortHealth& health,
             const std::optional<wire::Judgement>& judgement) {
  json json_of{{"name", port.name},
               {"direction", to_text(port.direction)},
               {"type", port.type.name},
               {"connections", health.connections},
               {"matched", health.matched},
               {"samples", health.samples},
               {"lost", health.lost},
               {"dropped", health.dropped},
               {"refused", health.refused},
               {"untimed", health.untimed},
               {"late", health.late},
               {"safe", health.safe},
               {"age_us", health.age_ns < 0 ? json(nullptr) : json(static_cast<double>(health.age_ns) / 1e3)},
               {"incompatible", health.incompatible.empty() ? json(nullptr) : json(health.incompatible)},
               {"losing", health.losing},
               {"dropping", health.dropping}};
  if (judgement) {
    json_of["rating"] = to_text(judgement->rating);
    json_of["reason"] = judgement->reason();
  }
  return json_of;
}

}  // namespace

Standing Supervisor::standing() const {
  Standing standing{
      .real_time = parts_.real_time,
      .host_pid = hosts_.empty() || !hosts_.front()->process->running() ? 0 : hosts_.front()->process->pid(),
      .host_restarts = host_restarts_,
      .executing = 0,
      .faulty = {}};
  for (const auto& member : members_) {
    standing.executing += member->state() == lifecycle::State::executing ? 1 : 0;
    if (!is_faulty(*member) || !standing.faulty.empty()) continue;
    standing.faulty = "module " + member->model.name + " is in " + lifecycle::to_text(member->state()) +
                      (member->why.empty() ? "" : ": " + member->why);
  }
  return standing;
}

Measures Supervisor::measures() const {
  constexpr auto relaxed = std::memory_order_relaxed;
  Measures measures;
  const Instant now = time();
  const auto name = [this](auto& entry, const std::string& part) {
    wire::set(entry.path(), wire::path_of(parts_.cell.name, device().name, part));
    wire::set(entry.cell(), parts_.cell.name);
    wire::set(entry.device(), device().name);
    wire::set(entry.name(), part);
  };
  for (std::size_t e = 0; e < parts_.channel.executors(); ++e) {
    const channel::ExecutorBlock& block = parts_.channel.executor(e);
    ExecutorStatistics entry;
    name(entry, device().executors[e].name);
    entry.cycles(block.cycles.load(relaxed));
    entry.missed(block.missed.load(relaxed));
    entry.late(block.late.load(relaxed));
    entry.margin_us(static_cast<double>(block.margin_ns.load(relaxed)) / 1e3);
    entry.jitter_us(on_the_wire(block.jitter.read()));
    measures.executors.push_back(entry);
  }
  for (const auto& member : members_) {
    const channel::ModuleBlock& block = member->block;
    ModuleStatistics entry;
    name(entry, member->model.name);
    entry.cycles(member->releases());
    entry.missed(block.missed.load(relaxed));
    entry.overruns(member->overruns());
    entry.over_budget(block.over_budget.load(relaxed));
    entry.errors(member->errors);
    entry.recoveries(member->recoveries);
    entry.jitter_us(on_the_wire(jitter_of(*member).read()));
    entry.run_us(on_the_wire(run_of(*member).read()));
    entry.process_id(member->is_thread() ? host_of(*member).process->pid() : member->program->pid());
    measures.modules.push_back(entry);
    const model::ModulePorts& ports = parts_.ports.at(member->index);
    if (!ports) continue;
    for (const model::Port& port : *ports) {
      const PortHealth health = health_->of(*member, port, now);
      PortStatus status;
      wire::set(status.forced(), forces_->by(*member, port.name));
      wire::set(status.path(),
                wire::path_of(parts_.cell.name, device().name, member->model.name) + "/" + port.name);
      wire::set(status.cell(), parts_.cell.name);
      wire::set(status.device(), device().name);
      wire::set(status.name(), member->model.name);
      wire::set(status.port(), port.name);
      status.output(port.direction == model::Direction::out);
      wire::set(status.type(), port.type.name);
      status.matched(health.matched);
      status.connections(health.connections);
      status.samples(health.samples);
      status.lost(health.lost);
      status.dropped(health.dropped);
      status.late(health.late);
      status.safe(status.output() ? member->in_safe_stop() : health.safe);
      status.age_ns(health.age_ns);
      wire::set(status.incompatible(), health.incompatible);
      measures.ports.push_back(status);
    }
  }
  return measures;
}

json Supervisor::report() const {
  constexpr auto relaxed = std::memory_order_relaxed;
  const Instant now = time();
  json executors = json::array();
  for (std::size_t e = 0; e < parts_.channel.executors(); ++e) {
    const channel::ExecutorBlock& block = parts_.channel.executor(e);
    executors.push_back({{"name", device().executors[e].name},
                         {"cycles", block.cycles.load(relaxed)},
                         {"missed", block.missed.load(relaxed)},
                         {"margin_us", static_cast<double>(block.margin_ns.load(relaxed)) / 1e3},
                         {"jitter_us", in_microseconds(block.jitter.read())}});
  }
  const bool contracts = std::any_of(members_.begin(), members_.end(), [this](const auto& member) {
    return model::contract_of(device(), member->model).what != model::Overrun::skip;
  });
  json modules = json::array();
  for (const auto& member : members_) {
    const channel::ModuleBlock& block = member->block;
    modules.push_back(
        {{"name", member->model.name},
         {"type", model::to_text(member->model.type)},
         {"operation", model::to_text(member->model.operation)},
         {"state", lifecycle::to_text(member->state())},
         {"cycles", member->releases()},
         {"overruns", member->overruns()},
         {"errors", member->errors},
         {"jitter_us", in_microseconds(jitter_of(*member).read())},
         {"run_us", in_microseconds(run_of(*member).read())},
         {"pid", member->is_thread() ? host_of(*member).process->pid() : member->program->pid()}});
    // Add the following members only where they apply. `text` states why the module is not in its target
    // state, that it has finished, or that it is in a safe stop. The other members say more about the state,
    // and are counts for overrun contracts and budgets, and the health of ports.
    const bool given_up = is_faulty(*member) && member->state() == lifecycle::State::destruct;
    if (is_faulty(*member) && !member->why.empty())
      modules.back()["text"] = member->why + (given_up ? way_out(*member) : "");
    if (given_up) modules.back()["given_up"] = true;
    if (member->stopped()) modules.back()["stopped"] = true;
    if (member->has_finished()) modules.back()["text"] = kFinished;
    if (member->in_safe_stop()) {
      modules.back()["text"] = kSafeStop;
      modules.back()["safe_stop"] = true;
    }
    if (contracts) modules.back()["missed"] = block.missed.load(relaxed);
    if (member->model.tolerance.times || member->model.tolerance.in_a_row)
      modules.back()["over_budget"] = block.over_budget.load(relaxed);
    const model::ModulePorts& ports = parts_.ports.at(member->index);
    if (!ports || ports->empty()) continue;
    json& list = modules.back()["ports"] = json::array();
    for (const model::Port& port : *ports) {
      PortHealth health = health_->of(*member, port, now);
      health.forced = forces_->by(*member, port.name);
      // The values of a module that has not run since its start are old, but this is no fault.
      list.push_back(
          in_json(port, health, member->awaits_release() ? std::nullopt : health_->judge(port, health)));
      if (json forced = forces_->report(*member, port.name, now); !forced.is_null())
        list.back()["forced"] = std::move(forced);
    }
  }
  json report{{"name", device().name},
              {"alive", true},
              {"real_time", parts_.real_time},
              {"executors", executors},
              {"modules", modules}};
  platform_->add_to(report);
  return report;
}

}  // namespace takt::supervision
