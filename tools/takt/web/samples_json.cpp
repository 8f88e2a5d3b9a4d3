#include "web/samples_json.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <takt/schedule/plan.hpp>
#include <takt/wire/words.hpp>

#include "reports/connections_report.hpp"
#include "reports/page.hpp"

namespace takt::tool::web {

namespace {

double in_ms(std::int64_t ns) { return static_cast<double>(ns) / 1e6; }

Json in_json(const Distribution& d) {
  return {{"mean", d.mean()}, {"p50", d.p50()}, {"p99", d.p99()}, {"p999", d.p999()}, {"max", d.max()}};
}

Json executor_json(const model::Device& device, const schedule::ExecutorPlan& plan) {
  const auto names = [&device](const std::vector<std::uint32_t>& modules) {
    Json list = Json::array();
    for (const auto module : modules) list.push_back(device.modules[module].name);
    return list;
  };
  Json rows = Json::array();
  const std::size_t sent = plan.periodic.empty() ? 0 : std::min(plan.rows(), kMostRows);
  for (std::size_t row = 0; row < sent; ++row) rows.push_back(names(plan.row(row)));
  Json json{{"name", device.executors[plan.executor].name},
            {"basic_period_ns", plan.basic_period.count()},
            {"macro_period_ns", plan.macro_period.count()},
            {"rows", std::move(rows)},
            {"sporadic", names(plan.sporadic)}};
  if (!plan.periodic.empty() && plan.rows() > sent) json["rows_left_out"] = plan.rows() - sent;
  return json;
}

Json module_json(const model::Module& module) {
  Json json{{"name", module.name},
            {"type", model::to_text(module.type)},
            {"operation", model::to_text(module.operation)}};
  if (module.period) json["period_ns"] = module.period->count();
  if (module.deadline) json["deadline_ns"] = module.deadline->count();
  json["priority"] = module.priority;
  if (!module.executor.empty()) json["executor"] = module.executor;
  if (module.budget) json["budget_ns"] = module.budget->count();
  return json;
}

Json end_json(const model::Endpoint& end) { return end.given() ? Json(to_text(end)) : Json(); }

}  // namespace

// Each state and health is drawn with the longest possible text, so that the page can later replace the text
// by any other.
std::string graph_of(const model::Cell& cell, const GraphPage& page) {
  CellHealth health;
  for (const model::Device& device : cell.devices) {
    health.devices[device.name] = {};
    for (const model::Module& module : device.modules)
      health.modules[device.name + "." + module.name] = to_text(STATE_INITIALIZE);
  }
  for (std::size_t i = 0; i < cell.connections.size(); ++i)
    health.connections[i] = {.safe = true, .age = std::chrono::milliseconds{999}};
  return graph_svg(cell, health, &page);
}

Json device_json(const wire::ObservedDevice& device) {
  const DeviceStatus& s = device.status;
  Json json{
      {"name", device.name()},
      {"alive", device.alive},
      {"state", to_text(s.state())},
      {"health", to_text(s.health())},
      {"rating", wire::to_text(wire::judge(wire::DeviceReport{
                     .state = to_text(s.state()), .health = to_text(s.health()), .alive = device.alive}))},
      {"text", s.text().to_string()},
      {"machine", s.host_name().to_string()},
      {"real_time", s.real_time()},
      {"process_id", s.process_id()},
      {"host_process_id", s.host_process_id()},
      {"host_restarts", s.host_restarts()}};
  // In whole milliseconds, because each change is sent to all pages.
  if (s.clock_error_ns() > 0) {
    const double offset = in_ms(s.clock_offset_ns());
    const double rounded = std::round(offset);
    json["clock_ms"] = {{"offset", static_cast<std::int64_t>(rounded)},
                        {"error", static_cast<std::int64_t>(
                                      std::ceil(in_ms(s.clock_error_ns()) + std::abs(offset - rounded)))}};
  }
  return json;
}

Json module_json(const LifecycleStatus& s) {
  return {{"name", s.device().to_string() + "." + s.name().to_string()},
          {"state", to_text(s.state())},
          {"rating", wire::to_text(wire::judge(wire::ModuleReport{.state = to_text(s.state()),
                                                                  .given_up = s.event() == EVENT_GIVE_UP}))},
          {"previous", to_text(s.previous_state())},
          {"event", to_text(s.event())},
          {"error", to_text(s.error())},
          {"text", s.text().to_string()},
          {"sequence", s.sequence_number()},
          {"time_ms", in_ms(s.time_ns())}};
}

Json fault_json(const model::Fault& f) {
  return {{"device", f.device},
          {"module", f.module},
          {"kind", model::to_text(f.kind)},
          {"severity", model::to_text(model::severity_of(f.kind))},
          {"error", f.error},
          {"cause", f.cause},
          {"attachment", f.attachment},
          {"count", f.count},
          {"cycle", f.cycle},
          {"sequence", f.sequence},
          {"time_ms", in_ms(f.time_ns)}};
}

Json alarm_json(const model::Alarm& a) {
  Json acknowledged = nullptr;
  if (const auto& said = a.acknowledged)
    acknowledged = {{"by", said->by}, {"note", said->note}, {"time_ms", in_ms(said->time_ns)}};
  return {{"device", a.device},
          {"module", a.module},
          {"kind", model::to_text(a.kind)},
          {"severity", model::to_text(model::severity_of(a.kind))},
          {"error", a.error},
          {"cause", a.cause},
          {"count", a.count},
          {"number", a.number},
          {"since_ms", in_ms(a.since_ns)},
          {"state", model::state_of(a)},
          {"acknowledged", std::move(acknowledged)}};
}

bool in_safe_stop(const wire::ObservedDevice& device, const std::string& module) {
  const auto& ports = device.deployment.ports;
  for (auto at = ports.lower_bound(module + "."); at != ports.end() && at->first.starts_with(module + ".");
       ++at) {
    if (at->second.status.output() && at->second.status.safe()) return true;
  }
  return false;
}

std::string forced_inputs(const wire::ObservedDevice& device, const std::string& module) {
  std::string list;
  const auto& ports = device.deployment.ports;
  for (auto at = ports.lower_bound(module + "."); at != ports.end() && at->first.starts_with(module + ".");
       ++at) {
    const PortStatus& status = at->second.status;
    if (status.forced().size() == 0) continue;
    list += (list.empty() ? "" : ", ") + status.port().to_string() + " by " + status.forced().to_string();
  }
  return list;
}

std::string short_text(const recording::Columns& columns, const std::vector<recording::Value>& values) {
  constexpr std::size_t kLongest = 8;
  const auto there = static_cast<std::size_t>(std::count_if(
      values.begin(), values.end(), [](const recording::Value& value) { return value.there(); }));
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i].there() || !columns.all()[i].drawable) continue;
    const bool enumeration = !columns.all()[i].enumerators.empty();
    std::string text = values[i].text();
    if (text.size() > kLongest)
      text = enumeration ? text.substr(0, kLongest) + "..." : fmt::format("{:.4g}", values[i].number(false));
    if (const std::string& unit = columns.all()[i].unit; !unit.empty()) text += " " + unit;
    return there == 1 ? text : text + fmt::format(" +{}", there - 1);
  }
  return count(there, "field");
}

ObservedCell::Port observed(const wire::ObservedPort& port) {
  const PortStatus& status = port.status;
  ObservedCell::Port result{.matched = status.matched() > 0,
                            .safe = !status.output() && status.safe(),
                            .losing = port.losing(),
                            .dropping = port.dropping(),
                            .lost = status.lost(),
                            .dropped = status.dropped(),
                            .late = status.late(),
                            .incompatible = status.incompatible().to_string(),
                            .forced = status.forced().to_string()};
  if (status.age_ns() >= 0) result.age = Nanoseconds{status.age_ns()};
  return result;
}

CellHealth health_of(const model::Cell& cell, const std::vector<wire::ObservedDevice>& devices) {
  ObservedCell result;
  for (const wire::ObservedDevice& device : devices) {
    if (device.status.cell().to_string() != cell.name) continue;
    result.devices[device.name()] = {.alive = device.alive, .text = device.status.text().to_string()};
    if (device.alive && !wire::executes(device.status)) continue;  // else its values only grow old
    const auto& modules = device.deployment.modules;
    for (const auto& [name, port] : device.deployment.ports) {
      const auto module = modules.find(name.substr(0, name.find('.')));
      if (module != modules.end() && wire::awaits_release(module->second)) continue;  // the same
      result.ports[device.name() + "." + name] = observed(port);
    }
  }
  return tool::health_of(cell, result);
}

Json measures_json(const std::vector<wire::ObservedDevice>& devices, const model::Cell* cell,
                   std::int64_t time_ns) {
  Json modules = Json::object();
  Json executors = Json::object();
  for (const wire::ObservedDevice& device : devices) {
    for (const auto& [name, m] : device.deployment.statistics) {
      modules[device.name() + "." + name] = {{"cycles", m.cycles()},
                                             {"missed", m.missed()},
                                             {"overruns", m.overruns()},
                                             {"over_budget", m.over_budget()},
                                             {"errors", m.errors()},
                                             {"recoveries", m.recoveries()},
                                             {"jitter_us", in_json(m.jitter_us())},
                                             {"run_us", in_json(m.run_us())}};
      if (in_safe_stop(device, name)) modules[device.name() + "." + name]["safe_stop"] = true;
      if (const std::string forced = forced_inputs(device, name); !forced.empty())
        modules[device.name() + "." + name]["forced"] = forced;
    }
    for (const auto& [name, e] : device.deployment.executors) {
      executors[device.name() + "." + name] = {{"cycles", e.cycles()},
                                               {"missed", e.missed()},
                                               {"late", e.late()},
                                               {"margin_us", e.margin_us()},
                                               {"jitter_us", in_json(e.jitter_us())}};
    }
  }
  Json connections = Json::object();
  if (cell != nullptr) {
    for (const auto& [index, c] : health_of(*cell, devices).connections) {
      Json& one = connections[std::to_string(index)];
      const wire::Judgement judgement = wire::judge(c);
      one = {{"rating", wire::to_text(judgement.rating)},
             {"word", judgement.word},
             {"reason", judgement.reason()},
             {"matched", c.matched},
             {"stale", c.stale()},
             {"safe", c.safe},
             {"age_us", c.age ? Json(static_cast<double>(c.age->count()) / 1e3) : Json()},
             {"lost", c.lost},
             {"dropped", c.dropped},
             {"late", c.late}};
      if (!c.incompatible.empty()) one["incompatible"] = c.incompatible;
    }
  }
  return {{"time_ms", in_ms(time_ns)},
          {"modules", std::move(modules)},
          {"executors", std::move(executors)},
          {"connections", std::move(connections)}};
}

Json cell_json(const model::Cell* cell, int domain, const std::string& deployment) {
  Json json{{"cell", nullptr},
            {"domain", domain},
            {"deployment", deployment},
            {"devices", Json::array()},
            {"connections", Json::array()},
            {"graph", nullptr}};
  if (cell == nullptr) return json;
  json["cell"] = cell->name;
  for (const model::Device& device : cell->devices) {
    Json modules = Json::array();
    for (const model::Module& module : device.modules) modules.push_back(module_json(module));
    Json executors = Json::array();
    if (const auto plan = schedule::plan(*cell, device)) {
      for (const schedule::ExecutorPlan& one : plan->executors)
        executors.push_back(executor_json(device, one));
    }
    json["devices"].push_back(
        {{"name", device.name}, {"executors", std::move(executors)}, {"modules", std::move(modules)}});
  }
  for (const model::Connection& connection : cell->connections) {
    json["connections"].push_back({{"from", end_json(connection.from)},
                                   {"to", end_json(connection.to)},
                                   {"kind", kind_text(connection)},
                                   {"text", described(connection)}});
    if (connection.deadline) json["connections"].back()["deadline_ns"] = connection.deadline->count();
  }
  json["graph"] = graph_of(*cell, {});
  return json;
}

}  // namespace takt::tool::web
