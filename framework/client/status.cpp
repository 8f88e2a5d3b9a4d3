#include <takt/client/status.hpp>

#include <algorithm>
#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include <takt/dds/words.hpp>
#include <takt/model/json.hpp>

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

// "a", or "a, b" where there are devices of two cells; "-" where none has one.
std::string names(const std::set<std::string>& cells) {
  std::string text;
  for (const std::string& cell : cells) text += (text.empty() ? "" : ", ") + cell;
  return text.empty() ? std::string{dds::kNoCell} : text;
}

/// What the devices say of themselves, and of each other.
struct Reports {
  std::map<std::string, json> devices;
  std::map<std::string, json> lost;  ///< as another one has heard them last
  std::set<std::string> named;       ///< those of their cells
  Problems problems;

  void ask(Operator& asker, const std::set<std::string>& names);
  /// Throws where it is no report.
  void hear(const std::string& name, json report);
  [[nodiscard]] std::set<std::string> missing() const {
    std::set<std::string> names;
    for (const std::string& name : named) {
      if (!devices.contains(name) && !lost.contains(name)) names.insert(name);
    }
    return names;
  }
};

void Reports::ask(Operator& asker, const std::set<std::string>& names) {
  std::vector<Question> questions;
  for (const std::string& name : names) questions.push_back({.kind = COMMAND_REPORT, .device = name});
  auto answers = asker.ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& name = questions[i].device;
    const auto answer = accepted(std::move(answers[i]));
    if (!answer) {
      problems.insert(problems.end(), answer.problems().begin(), answer.problems().end());
      continue;
    }
    try {
      hear(name, model::parse_json(answer->data));
    } catch (const json::exception&) {
      problems.push_back({"device " + name, "its report cannot be read", "is it of the same version?"});
    }
  }
}

void Reports::hear(const std::string& name, json report) {
  for (const json& device : report.at("lost")) {
    const json modules = device.at("modules");
    lost.try_emplace(device.at("name").get<std::string>(), lost_device(device.at("name"), modules));
  }
  for (const json& other : report.at("devices")) named.insert(other.get<std::string>());
  report.erase("lost");
  report.erase("devices");
  devices[name] = std::move(report);
}

std::set<std::string> alive(const std::vector<dds::SeenDevice>& seen) {
  std::set<std::string> names;
  for (const dds::SeenDevice& device : seen) {
    if (device.alive) names.insert(device.name());
  }
  return names;
}

}  // namespace

Result<json> status(Operator& asker, Nanoseconds limit) {
  const Observer& observer = asker.observer();
  observer.settle(limit);
  const std::set<std::string> found = alive(observer.devices());
  if (found.empty()) {
    const std::string domain = std::to_string(asker.domain());
    return fail("no device is on domain " + domain, "start one: takt-node --device NAME --domain " + domain);
  }
  Reports reports;
  reports.ask(asker, found);
  // Those that the others know and we have not found yet, as when a cable has just been put in.
  if (const std::set<std::string> missing = reports.missing(); !missing.empty()) {
    const auto are_there = [&missing](const std::vector<dds::SeenDevice>& seen) {
      const std::set<std::string> names = alive(seen);
      return std::includes(names.begin(), names.end(), missing.begin(), missing.end());
    };
    observer.wait(are_there, limit);
    std::set<std::string> late;
    for (const std::string& name : alive(observer.devices())) {
      if (missing.contains(name)) late.insert(name);
    }
    if (!late.empty()) reports.ask(asker, late);
  }
  // Two nodes of one name, or one that was lost while it was asked: there is no whole picture then.
  if (!reports.problems.empty()) return reports.problems;
  for (auto& [name, device] : reports.lost) reports.devices.try_emplace(name, std::move(device));
  for (const std::string& name : reports.missing()) reports.devices[name] = lost_device(name, json::array());

  std::set<std::string> cells;
  for (const dds::SeenDevice& seen : observer.devices()) {
    if (seen.status.cell() != std::string{dds::kNoCell}) cells.insert(seen.status.cell().to_string());
  }
  json list = json::array();
  for (auto& [name, device] : reports.devices) list.push_back(std::move(device));
  return json{{"cell", names(cells)}, {"devices", list}};
}

}  // namespace takt::client
