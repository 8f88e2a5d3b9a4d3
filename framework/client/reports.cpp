#include <takt/client/reports.hpp>

#include <algorithm>
#include <utility>
#include <vector>

#include <takt/model/json.hpp>

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

/// Throws where it is no report.
void hear(Reports& reports, const std::string& name, json report) {
  for (const json& device : report.at("lost"))
    reports.lost.try_emplace(device.at("name").get<std::string>(), device.at("modules"));
  for (const json& other : report.at("devices")) reports.named.insert(other.get<std::string>());
  report.erase("lost");
  report.erase("devices");
  reports.devices[name] = std::move(report);
}

void ask(Reports& reports, Operator& asker, const std::set<std::string>& names) {
  std::vector<Question> questions;
  for (const std::string& name : names) questions.push_back({.kind = COMMAND_REPORT, .device = name});
  auto answers = asker.ask(questions);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& name = questions[i].device;
    const auto answer = accepted(std::move(answers[i]));
    if (!answer) {
      reports.problems.insert(reports.problems.end(), answer.problems().begin(), answer.problems().end());
      continue;
    }
    try {
      hear(reports, name, model::parse_json(answer->data));
    } catch (const json::exception&) {
      reports.problems.push_back(
          {"device " + name, "its report cannot be read", "is it of the same version?"});
    }
  }
}

}  // namespace

std::set<std::string> Reports::missing() const {
  std::set<std::string> names;
  for (const std::string& name : named) {
    if (!devices.contains(name) && !lost.contains(name)) names.insert(name);
  }
  return names;
}

std::set<std::string> alive(const std::vector<dds::SeenDevice>& seen) {
  std::set<std::string> names;
  for (const dds::SeenDevice& device : seen) {
    if (device.alive) names.insert(device.name());
  }
  return names;
}

Result<Reports> all_reports(Operator& asker, Nanoseconds limit) {
  const Observer& observer = asker.observer();
  observer.settle(limit);
  const std::set<std::string> found = alive(observer.devices());
  if (found.empty()) {
    const std::string domain = std::to_string(asker.domain());
    return fail("no device is on domain " + domain, "start one: takt-node --device NAME --domain " + domain);
  }
  Reports reports;
  ask(reports, asker, found);
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
    if (!late.empty()) ask(reports, asker, late);
  }
  return reports;
}

}  // namespace takt::client
