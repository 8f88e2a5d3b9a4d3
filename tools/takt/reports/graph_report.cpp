#include "reports/graph_report.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include <fmt/format.h>

#include "reports/connections_report.hpp"
#include "reports/page.hpp"
#include "reports/run_report.hpp"

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;
using model::Cell;
using model::Connection;
using model::Device;
using model::Module;

template <class Map>
const typename Map::mapped_type* find(const Map& map, const typename Map::key_type& key) {
  const auto found = map.find(key);
  return found == map.end() ? nullptr : &found->second;
}

void device_state(Page& page, const CellHealth& health, const Device& device) {
  const auto* known = find(health.devices, device.name);
  if (known == nullptr) return;
  page.line(2, known->alive ? "alive" : page.warning("LOST"));
  if (!known->text.empty()) page.sentence(2, known->text);
}

/// Adds a table of a device's modules, or, if the table would be too wide, a list with two lines per module.
void modules_text(Page& page, const Device& device, const CellHealth& health) {
  const auto* known = find(health.devices, device.name);
  const auto state_of = [&](const Module& module) -> std::optional<std::string> {
    const auto* state = find(health.modules, device.name + "." + module.name);
    if (state == nullptr) return std::nullopt;
    return known != nullptr && !known->alive ? lost_text(*state) : *state;
  };
  const bool states = std::any_of(device.modules.begin(), device.modules.end(),
                                  [&](const Module& module) { return state_of(module).has_value(); });
  const std::size_t shown = std::min(device.modules.size(), kGraphModules);
  std::vector<Page::Words> rows{{"module", "type", "operation", "executor"}};
  if (states) rows.front().emplace_back("state");
  for (std::size_t i = 0; i < shown; ++i) {
    const Module& module = device.modules[i];
    rows.push_back({module.name, model::to_text(module.type), operation_text(module),
                    module.executor.empty() ? "-" : module.executor});
    if (states) rows.back().push_back(state_of(module).value_or("-"));
  }
  if (page.fits(2, rows)) {
    page.table(2, rows);
  } else {
    for (std::size_t i = 0; i < shown; ++i) {
      const Module& module = device.modules[i];
      page.line(2, module.name);
      page.sentence(4, std::string{model::to_text(module.type)} + ", " + operation_text(module) +
                           (module.executor.empty() ? "" : ", executor " + module.executor) +
                           (state_of(module) ? ", " + *state_of(module) : ""));
    }
  }
  if (shown < device.modules.size()) {
    page.line(2, fmt::format("... and {} more; --json lists them all", device.modules.size() - shown));
  }
}

Json module_json(const Device& device, const Module& module, const CellHealth& health) {
  Json json{{"name", module.name},
            {"type", model::to_text(module.type)},
            {"operation", model::to_text(module.operation)}};
  if (module.period) json["period_ns"] = module.period->count();
  if (module.deadline) {
    json["deadline_ns"] = module.deadline->count();
    json["miss"] = model::to_text(module.miss);
  }
  if (module.operation == model::Operation::sporadic) json["dispatch"] = model::to_text(module.dispatch);
  if (module.interarrival) json["interarrival_ns"] = module.interarrival->count();
  json["priority"] = module.priority;
  if (!module.executor.empty()) json["executor"] = module.executor;
  if (module.budget) json["budget_ns"] = module.budget->count();
  if (const auto* state = find(health.modules, device.name + "." + module.name)) json["state"] = *state;
  return json;
}

Json end_json(const model::Endpoint& end) { return end.given() ? Json(to_text(end)) : Json(); }

Json health_json(const CellHealth::Connection& health) {
  const wire::Judgement judgement = wire::judge(health);
  Json json{{"rating", wire::to_text(judgement.rating)},
            {"reason", judgement.reason()},
            {"matched", health.matched},
            {"stale", health.stale()}};
  if (health.age) json["age_ns"] = health.age->count();
  json["lost"] = health.lost;
  json["dropped"] = health.dropped;
  json["late"] = health.late;
  if (!health.incompatible.empty()) json["incompatible"] = health.incompatible;
  return json;
}

Json connection_json(const Cell& cell, const Connection& connection) {
  Json json{{"from", end_json(connection.from)},
            {"to", end_json(connection.to)},
            {"kind", model::to_text(connection.kind)}};
  if (connection.kind == model::ConnectionKind::queue) json["depth"] = connection.depth;
  json["reliability"] = model::to_text(connection.reliability);
  if (connection.deadline) {
    json["deadline_ns"] = connection.deadline->count();
    json["stale"] = model::to_text(connection.stale);
  }
  if (connection.lifespan) json["lifespan_ns"] = connection.lifespan->count();
  if (connection.carries != model::Carries::samples) json["carries"] = model::to_text(connection.carries);
  json["topic"] = topic_of(cell, connection);
  if (connection.domain) json["domain"] = *connection.domain;
  return json;
}

Json discovery_json(const Cell& cell) {
  Json json{{"kind", model::to_text(cell.discovery.kind)}};
  if (!cell.discovery.peers.empty()) json["peers"] = cell.discovery.peers;
  if (!cell.discovery.server.empty()) json["server"] = cell.discovery.server;
  if (!cell.server_device.empty()) json["server_device"] = cell.server_device;
  return json;
}

}  // namespace

CellHealth health_of(const Cell& cell, const ObservedCell& observed) {
  CellHealth health;
  health.given_up = observed.given_up;
  health.safe_stops = observed.safe_stops;
  for (const Device& device : cell.devices) {
    if (const auto* known = find(observed.devices, device.name)) health.devices[device.name] = *known;
    for (const Module& module : device.modules) {
      const std::string name = device.name + "." + module.name;
      if (const auto* state = find(observed.modules, name)) health.modules[name] = *state;
    }
  }
  for (std::size_t i = 0; i < cell.connections.size(); ++i) {
    const Connection& connection = cell.connections[i];
    // Use the reader's report if there is one, because it has more data than the writer's. On a topic for
    // other programs, the cell has only a writer. A lost device reports nothing.
    const auto* port = find(observed.ports, to_text(connection.to.given() ? connection.to : connection.from));
    const auto is_lost = [&](const model::Endpoint& end) {
      const auto* device = find(health.devices, end.device);
      return device != nullptr && !device->alive;
    };
    const bool lost = is_lost(connection.from) || is_lost(connection.to);
    if (port == nullptr && !lost) continue;
    health.connections[i] = health_of(port == nullptr ? ObservedCell::Port{} : *port, &connection, lost);
  }
  return health;
}

CellHealth::Connection health_of(const ObservedCell::Port& port, const Connection* connection,
                                 bool end_lost) {
  const bool reads = connection != nullptr && connection->to.given();
  return {
      .matched = !end_lost && port.matched,
      .outside = !end_lost && connection != nullptr && !(connection->from.given() && connection->to.given()),
      .output = connection != nullptr && !reads,
      .safe = port.safe,
      .age = port.age,
      .deadline = reads ? connection->deadline : std::nullopt,
      .losing = port.losing,
      .dropping = port.dropping,
      .lost = port.lost,
      .dropped = port.dropped,
      .late = port.late,
      .incompatible = port.incompatible,
      .forced = port.forced};
}

CellHealth health_of(const Cell& cell, const Json& status) {
  const std::string cells = ", " + status.at("cell").get<std::string>() + ", ";
  if (cells.find(", " + cell.name + ", ") == std::string::npos) return {};
  ObservedCell observed;
  for (const Json& device : status.at("devices")) {
    const auto name = device.at("name").get<std::string>();
    observed.devices[name] = {.alive = device.at("alive").get<bool>()};
    const std::string device_state = device.value("state", "running");
    const bool runs = device_state == "running" || device_state == "started";
    for (const Json& module : device.at("modules")) {
      const std::string path = name + "." + module.at("name").get<std::string>();
      observed.modules[path] = module.at("state").get<std::string>();
      if (module.value("given_up", false)) observed.given_up.insert(path);
      if (module.value("safe_stop", false)) observed.safe_stops.insert(path);
      const bool awaits_release = observed.modules[path] == "START" && !module.value("stopped", false);
      if (!module.contains("ports") || !runs || awaits_release) continue;  // else its values only grow old
      for (const Json& port : module["ports"]) {
        ObservedCell::Port one{.matched = port.at("matched").get<std::uint64_t>() > 0,
                               .safe = port.value("safe", false),
                               .losing = port.value("losing", false),
                               .dropping = port.value("dropping", false),
                               .lost = port.at("lost").get<std::uint64_t>(),
                               .dropped = port.at("dropped").get<std::uint64_t>(),
                               .late = port.at("late").get<std::uint64_t>()};
        if (const Json& age = port.at("age_us"); !age.is_null()) {
          one.age =
              std::chrono::round<Nanoseconds>(std::chrono::duration<double, std::micro>(age.get<double>()));
        }
        if (const Json& policy = port.at("incompatible"); !policy.is_null())
          one.incompatible = policy.get<std::string>();
        if (port.contains("forced")) one.forced = port["forced"].at("by").get<std::string>();
        observed.ports[path + "." + port.at("name").get<std::string>()] = std::move(one);
      }
    }
  }
  return health_of(cell, observed);
}

namespace {

// Rounds an age to microseconds, or to milliseconds if it is 10 ms or more.
Nanoseconds rounded(Nanoseconds age) {
  if (age < std::chrono::milliseconds{10}) return std::chrono::round<std::chrono::microseconds>(age);
  return std::chrono::round<std::chrono::milliseconds>(age);
}

}  // namespace

std::string health_text(const CellHealth::Connection& health) {
  const wire::Judgement judgement = wire::judge(health);
  std::string text = judgement.reason();
  if (judgement.rating == wire::Rating::bad || judgement.rating == wire::Rating::broken) {
    std::transform(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(judgement.word.size()),
                   text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  }
  if (!health.incompatible.empty()) return text;
  if (health.age) text += ", " + to_text(rounded(*health.age)) + " old";
  const auto add = [&](std::uint64_t number, const char* what) {
    if (number > 0) text += fmt::format(", {} {}", what, number);
  };
  add(health.lost, "lost");
  add(health.dropped, "dropped");
  add(health.late, "late");
  return text;
}

std::string graph_text(const Cell& cell, const CellHealth& health, Style style) {
  std::size_t modules = 0;
  for (const Device& device : cell.devices) modules += device.modules.size();
  Page page{style};
  page.heading(0, "cell " + cell.name,
               count(cell.devices.size(), "device") + ", " + count(modules, "module") + ", " +
                   count(cell.connections.size(), "connection"));
  if (is_on_network(cell)) page.sentence(0, network_text(cell));
  for (const Device& device : cell.devices) {
    page.blank();
    page.line(0, page.bold("device " + device.name));
    device_state(page, health, device);
    modules_text(page, device, health);
  }
  std::map<std::size_t, std::string> states;
  for (const auto& [index, state] : health.connections)
    states[index] = mark_of(wire::judge(state).rating) + health_text(state);
  connections_text(page, cell, states);
  return std::move(page).take();
}

Json graph_json(const Cell& cell, const CellHealth& health) {
  Json devices = Json::array();
  for (const Device& device : cell.devices) {
    Json json{{"name", device.name}};
    if (const auto* known = find(health.devices, device.name)) {
      json["alive"] = known->alive;
      if (!known->text.empty()) json["text"] = known->text;
    }
    Json modules = Json::array();
    for (const Module& module : device.modules) modules.push_back(module_json(device, module, health));
    json["modules"] = std::move(modules);
    devices.push_back(std::move(json));
  }
  Json connections = Json::array();
  for (std::size_t i = 0; i < cell.connections.size(); ++i) {
    connections.push_back(connection_json(cell, cell.connections[i]));
    if (const auto* known = find(health.connections, i)) connections.back()["health"] = health_json(*known);
  }
  Json services = Json::array();
  for (const model::Service& service : cell.services)
    services.push_back({{"client", to_text(service.client)}, {"server", to_text(service.server)}});
  return Json{{"cell", cell.name},
              {"domain", cell.domain},
              {"discovery", discovery_json(cell)},
              {"devices", std::move(devices)},
              {"connections", std::move(connections)},
              {"services", std::move(services)}};
}

}  // namespace takt::tool
