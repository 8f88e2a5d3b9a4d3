#include <takt/client/status.hpp>

#include <map>
#include <set>

#include <nlohmann/json.hpp>

#include <takt/dds/words.hpp>

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

}  // namespace

Result<json> status(Operator& asker, Nanoseconds limit) {
  asker.observer().settle(limit);
  std::vector<Question> questions;
  std::set<std::string> cells;
  std::set<std::string> seen_names;
  std::map<std::string, json> devices;
  for (const dds::SeenDevice& seen : asker.observer().devices()) {
    if (seen.status.cell() != std::string{dds::kNoCell}) cells.insert(seen.status.cell().to_string());
    if (seen.alive && seen_names.insert(seen.name()).second)
      questions.push_back({.kind = COMMAND_REPORT, .device = seen.name()});
  }
  if (questions.empty()) {
    const std::string domain = std::to_string(asker.domain());
    return fail("no device is on domain " + domain, "start one: takt-node --device NAME --domain " + domain);
  }

  std::map<std::string, json> lost;
  Problems problems;
  auto answers = asker.ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& name = questions[i].device;
    const auto answer = accepted(std::move(answers[i]));
    if (!answer) {
      problems.insert(problems.end(), answer.problems().begin(), answer.problems().end());
      continue;
    }
    json report = json::parse(answer->data, nullptr, false);
    if (!report.is_object()) {
      problems.push_back({"device " + name, "its report cannot be read", "is it of the same version?"});
      continue;
    }
    for (const json& device : report.value("lost", json::array())) {
      json& place = lost[device.value("name", "")];
      if (place.is_null()) place = device.value("modules", json::array());
    }
    report.erase("lost");
    report.erase("devices");
    devices[name] = std::move(report);
  }
  // Two nodes of one name, or one that was lost while it was asked: there is no whole picture then.
  if (!problems.empty()) return problems;
  for (const auto& [name, modules] : lost) devices.try_emplace(name, lost_device(name, modules));

  json list = json::array();
  for (auto& [name, device] : devices) list.push_back(std::move(device));
  return json{{"cell", names(cells)}, {"devices", list}};
}

}  // namespace takt::client
