#include <takt/client/status.hpp>

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

json lost_device(const std::string& name, const json& modules) {
  json device{{"name", name},
              {"alive", false},
              {"real_time", false},
              {"executors", json::array()},
              {"modules", json::array()}};
  for (const json& module : modules) {
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

Result<json> status(Operator& asker, Nanoseconds limit) {
  auto found = all_reports(asker, limit);
  if (!found) return found.problems();
  Reports& reports = *found;
  // Each problem means that the status would be incomplete. For example, two nodes have the same device name,
  // or a node was lost before it answered.
  if (!reports.problems.empty()) return reports.problems;
  for (const auto& [name, modules] : reports.lost)
    reports.devices.try_emplace(name, lost_device(name, modules));
  for (const std::string& name : reports.missing()) reports.devices[name] = lost_device(name, json::array());

  std::set<std::string> cells;
  for (const wire::ObservedDevice& seen : asker.observer().devices()) {
    if (seen.status.cell() != std::string{wire::kNoCell}) cells.insert(seen.status.cell().to_string());
  }
  json list = json::array();
  for (auto& [name, device] : reports.devices) list.push_back(std::move(device));
  return json{{"cell", names(cells)}, {"devices", list}};
}

}  // namespace takt::client
