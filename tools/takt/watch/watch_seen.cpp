#include "watch/watch_seen.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include <takt/os/clock.hpp>
#include <takt/wire/words.hpp>

#include "reports/connections_report.hpp"
#include "web/samples_json.hpp"

namespace takt::tool {

namespace {

constexpr std::size_t kMinute = 60;
constexpr std::size_t kTransitions = 100;  // number of transitions that are kept for each module
constexpr std::size_t kGone = 1000;  // limit for modules that no longer exist or whose device is unknown
constexpr std::size_t kEvents = 100;
/// How long to wait for a node's descriptor or report before asking the node again.
constexpr std::chrono::seconds kAgain{5};
/// How long a received descriptor or report is used before the node is asked again, because an update may
/// have changed it.
constexpr std::chrono::seconds kFresh{30};

watch::Quantiles quantiles(const Distribution& d) {
  return {.mean = d.mean(), .p50 = d.p50(), .p99 = d.p99(), .p999 = d.p999(), .max = d.max()};
}

watch::Measured measured(const ModuleStatistics& s) {
  return {.cycles = s.cycles(),
          .missed = s.missed(),
          .overruns = s.overruns(),
          .over_budget = s.over_budget(),
          .errors = s.errors(),
          .recoveries = s.recoveries(),
          .jitter_us = quantiles(s.jitter_us()),
          .run_us = quantiles(s.run_us())};
}

// The rms jitter of the module in each of the last 60 seconds. A second without statistics is NaN.
std::vector<double> minute_of(const client::Series& series) {
  std::vector<double> minute(kMinute, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < series.times_ms.size(); ++i) {
    const std::int64_t before = (series.times_ms.back() - series.times_ms[i] + 500) / 1000;
    if (before < static_cast<std::int64_t>(kMinute))
      minute[kMinute - 1 - static_cast<std::size_t>(before)] = series.jitter_us[i];
  }
  return minute;
}

const model::Module* planned_of(const model::Cell* cell, const std::string& device, const std::string& name) {
  if (cell == nullptr) return nullptr;
  for (const model::Device& on : cell->devices) {
    if (on.name != device) continue;
    for (const model::Module& module : on.modules) {
      if (module.name == name) return &module;
    }
  }
  return nullptr;
}

watch::Planned planned(const model::Module& module) {
  return {.words = std::string{model::to_text(module.type)} + ", " + operation_text(module),
          .executor = module.executor,
          .priority = module.priority,
          .period = module.period,
          .budget = module.budget};
}

const wire::ObservedDevice* device_of(const std::vector<wire::ObservedDevice>& devices,
                                      const std::string& name) {
  const auto found =
      std::find_if(devices.begin(), devices.end(), [&](const auto& device) { return device.name() == name; });
  return found == devices.end() ? nullptr : &*found;
}

bool is_lost(const std::vector<wire::ObservedDevice>& devices, const std::string& name) {
  const wire::ObservedDevice* const device = device_of(devices, name);
  return device != nullptr && !device->alive;
}

/// True if the device at the other end of a connection of the port is lost.
bool has_lost_end(const std::vector<wire::ObservedDevice>& devices, const model::Endpoint& port,
                  const model::Cell& cell) {
  return std::any_of(cell.connections.begin(), cell.connections.end(), [&](const model::Connection& each) {
    return (each.from == port && is_lost(devices, each.to.device)) ||
           (each.to == port && is_lost(devices, each.from.device));
  });
}

/// Returns the connection by which the health of a port is judged: the connection into an input, or the
/// connection of an output that only other programs read. None for an output with readers in the cell, each
/// of which has a health of its own.
const model::Connection* connection_of(const model::Endpoint& port, const model::Cell& cell) {
  const model::Connection* outside = nullptr;
  for (const model::Connection& connection : cell.connections) {
    if (connection.to == port) return &connection;
    if (connection.from != port) continue;
    if (connection.to.given()) return nullptr;
    outside = &connection;
  }
  return outside;
}

std::vector<watch::Port> ports_of(const std::vector<wire::ObservedDevice>& devices,
                                  const wire::ObservedDevice& device, const std::string& module,
                                  const model::Cell* cell) {
  std::vector<watch::Port> ports;
  const auto& all = device.deployment.ports;
  for (auto at = all.lower_bound(module + "."); at != all.end() && at->first.starts_with(module + ".");
       ++at) {
    const PortStatus& status = at->second.status;
    const std::string name = status.port().to_string();
    const model::Endpoint here{device.name(), module, name};
    const model::Connection* const connection = cell == nullptr ? nullptr : connection_of(here, *cell);
    const bool end_lost = !device.alive || (cell != nullptr && has_lost_end(devices, here, *cell));
    const model::Endpoint source = status.output()         ? here
                                   : connection != nullptr ? connection->from
                                                           : model::Endpoint{};
    ports.push_back({.name = name,
                     .output = status.output(),
                     .type = status.type().to_string(),
                     .connected = status.connections() > 0,
                     .samples = status.samples(),
                     .health = health_of(web::observed(at->second), connection, end_lost),
                     .source = source.given() ? end_text(source) : ""});
  }
  return ports;
}

std::vector<watch::Connection> connections_of(const std::vector<wire::ObservedDevice>& devices,
                                              const model::Cell& cell) {
  const CellHealth health = web::health_of(cell, devices);
  std::vector<watch::Connection> connections;
  for (std::size_t i = 0; i < cell.connections.size(); ++i) {
    const model::Connection& each = cell.connections[i];
    watch::Connection one{.from = end_text(each.from), .to = end_text(each.to), .kind = kind_text(each)};
    if (const auto known = health.connections.find(i); known != health.connections.end())
      one.health = known->second;
    connections.push_back(std::move(one));
  }
  return connections;
}

}  // namespace

void Watched::add(const LifecycleStatus& s) {
  auto& all = transitions_[s.device().to_string() + "." + s.name().to_string()];
  std::string text;
  if (s.event() != EVENT_NONE) text = std::string{to_text(s.previous_state())} + " -> ";
  text += to_text(s.state());
  if (s.event() != EVENT_NONE) text += std::string{"  "} + to_text(s.event());
  if (!s.text().to_string().empty()) text += ": " + s.text().to_string();
  all.push_back({.time_ns = s.time_ns(), .text = std::move(text)});
  if (all.size() > kTransitions) all.erase(all.begin());
}

void Watched::add(const std::string& event) {
  events_.push_back(event);
  if (events_.size() > kEvents) events_.pop_front();
}

void Watched::add(const model::Fault& fault) {
  const model::Severity severity = model::severity_of(fault.kind);
  if (severity == model::Severity::note) return;
  const auto later = std::ranges::upper_bound(faults_, fault.time_ns, {}, &watch::Fault::time_ns);
  faults_.insert(later, {.time_ns = fault.time_ns,
                         .text = fmt::format(
                             "{} {}{}{}: {}{}{} {}", watch::clock_text(fault.time_ns), fault.device,
                             fault.module.empty() ? "" : ".", fault.module, model::to_text(fault.kind),
                             fault.error.empty() ? "" : ": " + fault.error,
                             fault.count > 1 ? fmt::format(" ({} times)", fault.count) : "", fault.cause),
                         .error = severity == model::Severity::error});
  if (faults_.size() > kEvents) faults_.pop_front();
}

void Watched::add(const std::string& deployment, std::shared_ptr<const model::Cell> cell) {
  if (cell != nullptr) cells_[deployment].cell = std::move(cell);
}

std::optional<Watched::Unknown> Watched::unknown(const std::vector<wire::ObservedDevice>& devices,
                                                 Instant now) {
  for (const wire::ObservedDevice& device : devices) {
    const std::string deployment = device.status.deployment().to_string();
    if (!device.alive || deployment.empty()) continue;
    const auto [at, is_new] = cells_.try_emplace(deployment);
    Known& known = at->second;
    if (!is_new && now - known.asked < (known.cell == nullptr ? kAgain : kFresh)) continue;
    known.asked = now;
    return Unknown{.device = device.name(), .deployment = deployment};
  }
  return std::nullopt;
}

std::optional<std::string> Watched::unreported(const std::vector<wire::ObservedDevice>& devices,
                                               Instant now) {
  for (const wire::ObservedDevice& device : devices) {
    const std::string deployment = device.status.deployment().to_string();
    if (!device.alive || deployment.empty()) continue;
    Reported& report = reports_[device.name()];
    if (report.deployment == deployment && now - report.asked < (report.components.empty() ? kAgain : kFresh))
      continue;
    report = {.deployment = deployment, .asked = now, .components = std::move(report.components)};
    return device.name();
  }
  return std::nullopt;
}

void Watched::add_components(const std::string& device, std::map<std::string, std::string> components) {
  reports_[device].components = std::move(components);
}

void Watched::add_missed(watch::Snapshot& snapshot, Known& known,
                         const std::vector<wire::ObservedDevice>& devices, Instant now) {
  for (const model::Device& device : known.cell->devices) {
    if (device_of(devices, device.name) != nullptr) {
      known.missed.erase(device.name);
      continue;
    }
    if (now - known.missed.try_emplace(device.name, now).first->second < kFound) continue;
    watch::Device lost{.name = device.name,
                       .cell = known.cell->name,
                       .state = "not found",
                       .health = to_text(HEALTH_FAILED),
                       .text = "the device was lost before takt watch started",
                       .alive = false};
    for (const model::Module& module : device.modules)
      lost.modules.push_back({.name = module.name, .state = "unknown", .planned = planned(module)});
    snapshot.devices.push_back(std::move(lost));
  }
}

watch::Snapshot Watched::snapshot(const std::vector<wire::ObservedDevice>& devices, Instant now) {
  history_.add(devices);
  // Forget the cells that no device runs any longer.
  std::erase_if(cells_, [&](const auto& entry) {
    return std::none_of(devices.begin(), devices.end(),
                        [&](const auto& d) { return d.status.deployment() == entry.first; });
  });
  watch::Snapshot snapshot{.domain = domain_,
                           .clock = watch::clock_text(os::wall_ns()).substr(0, 8),
                           .events = {events_.begin(), events_.end()},
                           .faults = {faults_.begin(), faults_.end()}};
  std::set<std::string> modules;
  for (const wire::ObservedDevice& each : devices) {
    const DeviceStatus& s = each.status;
    const auto known = cells_.find(s.deployment().to_string());
    const model::Cell* const cell = known == cells_.end() ? nullptr : known->second.cell.get();
    watch::Device device{.name = each.name(),
                         .cell = s.deployment().to_string().empty() ? "" : s.cell().to_string(),
                         .state = to_text(s.state()),
                         .health = to_text(s.health()),
                         .text = s.text().to_string(),
                         .alive = each.alive,
                         .real_time = s.real_time(),
                         .machine = s.host_name().to_string(),
                         .process_id = s.process_id(),
                         .host_process_id = s.host_process_id(),
                         .host_restarts = s.host_restarts(),
                         .alarms = s.unacknowledged_alarms()};
    for (const auto& [name, e] : each.deployment.executors) {
      device.executors.push_back({.name = name,
                                  .cycles = e.cycles(),
                                  .missed = e.missed(),
                                  .late = e.late(),
                                  .margin_us = e.margin_us(),
                                  .jitter_us = quantiles(e.jitter_us())});
    }
    for (const auto& [name, status] : each.deployment.modules) {
      const std::string path = device.name + "." + name;
      modules.insert(path);
      watch::Module module{.name = name, .state = to_text(status.state())};
      if (status.state() == STATE_RECOVER || status.state() == STATE_DESTRUCT)
        module.text = status.text().to_string();
      module.stopped = wire::is_stopped(status) && s.state() == DEVICE_RUNNING;
      module.given_up = status.event() == EVENT_GIVE_UP;
      module.safe_stop = status.state() == STATE_EXECUTING && web::in_safe_stop(each, name);
      if (module.safe_stop) module.text = "it is in a safe stop";
      const std::string forced = web::forced_inputs(each, name);
      module.forced = !forced.empty();
      if (module.forced && module.text.empty()) module.text = "forced: " + forced;
      if (const auto found = each.deployment.statistics.find(name); found != each.deployment.statistics.end())
        module.measured = measured(found->second);
      if (const model::Module* plan = planned_of(cell, device.name, name)) module.planned = planned(*plan);
      module.component = reports_[device.name].components[name];
      module.minute_us = minute_of(history_.of(path, kMinute + 2));
      module.ports = ports_of(devices, each, name, cell);
      module.transitions = transitions_[path];
      device.modules.push_back(std::move(module));
    }
    snapshot.devices.push_back(std::move(device));
  }
  for (auto& [deployment, known] : cells_) {
    if (known.cell == nullptr) continue;
    add_missed(snapshot, known, devices, now);
    snapshot.connections_known = true;
    const auto of_cell = connections_of(devices, *known.cell);
    snapshot.connections.insert(snapshot.connections.end(), of_cell.begin(), of_cell.end());
  }
  if (transitions_.size() > modules.size() + kGone)
    std::erase_if(transitions_, [&](const auto& entry) { return !modules.contains(entry.first); });
  return snapshot;
}

}  // namespace takt::tool
