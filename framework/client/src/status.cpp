#include <takt/client/status.hpp>

#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include <takt/wire/words.hpp>
#include "reports.hpp"

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

json nothing_measured() {
  return {{"mean", 0.0}, {"variance", 0.0}, {"min", 0.0}, {"p50", 0.0},
          {"p99", 0.0},  {"p999", 0.0},     {"max", 0.0}};
}

/// `known` is what another node knows about the device: its modules, and perhaps a text about it.
json lost_device(const std::string& name, const json& known) {
  json device{{"name", name},
              {"alive", false},
              {"real_time", false},
              {"executors", json::array()},
              {"modules", json::array()}};
  if (known.contains("text")) device["text"] = known["text"];
  for (const json& module : known.value("modules", json::array())) {
    device["modules"].push_back({{"name", module.value("name", "")},
                                 {"type", module.value("type", "thread")},
                                 {"operation", module.value("operation", "periodic")},
                                 {"state", module.value("state", "UNKNOWN")},
                                 {"cycles", 0},
                                 {"overruns", 0},
                                 {"errors", 0},
                                 {"jitter_us", nothing_measured()},
                                 {"run_us", nothing_measured()},
                                 {"pid", 0}});
  }
  return device;
}

// Returns the names of the cells that the devices run, such as "a" or "a, b"; "-" if they run none.
std::string names(const std::set<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ", ") + cell;
  return text.empty() ? std::string{wire::kNoCell} : text;
}

}  // namespace

std::vector<std::string> differences(const json& devices,
                                     const std::map<std::string, std::set<std::string>>& cells) {
  std::vector<std::string> all;
  for (const auto& [cell, names] : cells) {
    // The names of the devices, by the deployment and update that they have.
    std::map<std::string, std::string> having;
    for (const json& device : devices) {
      const auto name = device.value("name", "");
      if (!device.value("alive", false) || !names.contains(name)) continue;
      const auto text = [&device](const char* member) {
        const auto found = device.find(member);
        return found != device.end() && found->is_string() ? found->get<std::string>() : std::string{};
      };
      const std::string update = text("update");
      std::string what = text("deployment").empty() ? "no deployment" : "deployment " + text("deployment");
      if (!update.empty()) what += " with update " + update;
      having[what] += (having[what].empty() ? "" : ", ") + name;
    }
    if (having.size() < 2) continue;
    std::string line;
    for (const auto& [what, list] : having) line += (line.empty() ? "" : "; ") + list + ": " + what;
    all.push_back("the devices of cell " + cell + " differ: " + line +
                  "; to make them agree, run takt deploy --update with the descriptor of the cell, or takt "
                  "undeploy " +
                  cell);
  }
  return all;
}

Result<json> status(Operator& sender) {
  auto found = all_reports(sender);
  if (!found) return found.problems();
  Reports& reports = *found;
  // Fail if there is a problem, because the status would be incomplete: for example, a node was lost before
  // it answered.
  if (!reports.problems.empty()) return reports.problems;
  std::multimap<std::string, json> devices;  // by device name; two nodes may have the same device name
  for (const auto& [name, known] : reports.lost) {
    if (!reports.answered(name)) devices.emplace(name, lost_device(name, known));
  }
  for (const std::string& name : reports.missing()) devices.emplace(name, lost_device(name, json::object()));
  for (auto& [node, report] : reports.nodes) {
    const auto name = report["name"].get<std::string>();
    const auto seen = sender.observer().devices(name);
    const wire::ObservedDevice* twin = nullptr;
    bool alive = false;
    for (const wire::ObservedDevice& one : seen) {
      if (one.alive && one.node() == node) alive = true;
      if (one.alive && one.node() != node) twin = &one;
    }
    if (twin != nullptr && !alive) continue;  // the node was restarted; the new node has answered, too
    if (twin != nullptr && !report.contains("conflict"))  // the nodes have not discovered each other yet
      report["conflict"] = wire::name_conflict(twin->status, sender.domain());
    devices.emplace(name, std::move(report));
  }

  std::set<std::string> cells;
  for (const wire::ObservedDevice& seen : sender.observer().devices()) {
    if (seen.status.cell() != std::string{wire::kNoCell}) cells.insert(seen.status.cell().to_string());
  }
  json list = json::array();
  for (auto& [name, device] : devices) list.push_back(std::move(device));
  json whole{{"cell", names(cells)}, {"devices", list}};
  if (const auto differing = differences(list, reports.cells); !differing.empty())
    whole["differences"] = differing;
  return whole;
}

}  // namespace takt::client
