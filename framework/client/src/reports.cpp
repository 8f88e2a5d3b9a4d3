#include "reports.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include <takt/model/json.hpp>

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

/// Adds the report of device `name`. Throws json::exception if `report` lacks a member that every report has.
void add(Reports& reports, const std::string& name, json report) {
  for (const json& device : report.at("lost"))
    reports.lost.try_emplace(device.at("name").get<std::string>(), device.at("modules"));
  for (const json& other : report.at("devices")) reports.named.insert(other.get<std::string>());
  for (const json& node : report.at("heard")) reports.heard.insert(node.get<std::string>());
  reports.searching |= report.at("searching").get<bool>();
  for (const char* of_others : {"lost", "devices", "heard", "searching"}) report.erase(of_others);
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
      add(reports, name, model::parse_json(answer->data));
    } catch (const json::exception&) {
      reports.problems.push_back({"device " + name, "its report cannot be read",
                                  "check that it runs the same version of Takt as this program"});
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

std::set<std::string> alive(const std::vector<wire::ObservedDevice>& seen) {
  std::set<std::string> names;
  for (const wire::ObservedDevice& device : seen) {
    if (device.alive) names.insert(device.name());
  }
  return names;
}

Result<Reports> all_reports(Operator& asker, Nanoseconds limit) {
  const Observer& observer = asker.observer();
  if (!observer.wait([](const auto& seen) { return !alive(seen).empty(); }, limit)) {
    const std::string domain = std::to_string(asker.domain());
    return fail("no device found on domain " + domain,
                "start a node with takt-node --device NAME --domain " + domain);
  }
  Reports reports;
  std::set<std::string> asked;  // ids of nodes, not device names, because two nodes may have the same name
  const auto is_new = [&asked](const wire::ObservedDevice& seen) {
    return seen.alive && !asked.contains(seen.node());
  };
  const auto any_new = [&is_new](const std::vector<wire::ObservedDevice>& seen) {
    return std::any_of(seen.begin(), seen.end(), is_new);
  };
  const auto all_heard = [&reports, &observer] {
    std::set<std::string> known;
    for (const wire::ObservedDevice& seen : observer.devices()) known.insert(seen.node());
    return std::includes(known.begin(), known.end(), reports.heard.begin(), reports.heard.end());
  };
  Nanoseconds patience{0};
  do {
    std::set<std::string> names;
    for (const wire::ObservedDevice& seen : observer.devices()) {
      if (is_new(seen)) names.insert(seen.name());
      if (seen.alive) asked.insert(seen.node());
    }
    ask(reports, asker, names);
    // A device that other devices have lost may come back, so the search goes on for kQuiet.
    const bool none_lost =
        std::all_of(reports.lost.begin(), reports.lost.end(),
                    [&reports](const auto& lost) { return reports.devices.contains(lost.first); });
    const bool complete = all_heard() && none_lost && !reports.searching;
    patience = !reports.missing().empty() ? limit : complete ? Nanoseconds{0} : Nanoseconds{kQuiet};
  } while (observer.wait(any_new, patience));
  return reports;
}

}  // namespace takt::client
