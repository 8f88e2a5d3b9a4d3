#include "reports.hpp"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

#include <takt/client/answer_data.hpp>
#include <takt/os/clock.hpp>

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

/// Adds the report of a node to `reports`. Throws an exception, and adds nothing, if the report lacks a
/// member that each report has, or if a member has the wrong type.
void add(Reports& reports, const std::string& node, const json& answer) {
  json report = checked_report(answer);
  const auto name = report.at("name").get<std::string>();
  std::map<std::string, json> lost;
  for (const json& device : report.at("lost")) {
    const json& modules = device.at("modules");
    for (const json& module : modules) {
      for (const char* member : {"name", "type", "operation", "state"})
        static_cast<void>(module.at(member).get_ref<const std::string&>());
    }
    static_cast<void>(device.value("text", ""));
    lost.emplace(device.at("name").get<std::string>(), device);
  }
  const auto devices = report.at("devices").get<std::set<std::string>>();
  const auto cell = devices.empty() ? std::string{} : report.at("cell").get<std::string>();
  const auto heard = report.at("heard").get<std::set<std::string>>();
  const bool searching = report.at("searching").get<bool>();

  for (const json& module : report.at("modules")) {
    const auto of_module = module.at("name").get<std::string>();
    reports.modules.emplace(of_module, name + "." + of_module);
  }
  reports.lost.merge(lost);
  reports.named.insert(devices.begin(), devices.end());
  if (!devices.empty()) reports.cells[cell].insert(devices.begin(), devices.end());
  reports.discovered.insert(heard.begin(), heard.end());
  reports.searching |= searching;
  for (const char* of_others : {"lost", "devices", "heard", "searching"}) report.erase(of_others);
  reports.nodes[node] = std::move(report);
}

void add_reports(Reports& reports, Operator& sender, const std::vector<wire::ObservedDevice>& nodes,
                 const std::function<bool()>& give_up) {
  std::vector<CommandRequest> requests;
  for (const wire::ObservedDevice& each : nodes)
    requests.push_back({.kind = COMMAND_REPORT, .device = each.name(), .node = each.node()});
  auto answers = sender.send(requests, give_up);
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (!answer) {
      reports.problems.insert(reports.problems.end(), answer.problems().begin(), answer.problems().end());
      continue;
    }
    const auto read = read_answer(requests[i].device, answer->data,
                                  [&](const json& report) { add(reports, requests[i].node, report); });
    reports.problems.insert(reports.problems.end(), read.problems().begin(), read.problems().end());
  }
}

}  // namespace

bool Reports::complete(const Observer& observer) const {
  std::set<std::string> known;
  for (const wire::ObservedDevice& seen : observer.devices()) known.insert(seen.node());
  return !searching && std::includes(known.begin(), known.end(), discovered.begin(), discovered.end());
}

bool Reports::answered(const std::string& device) const {
  return std::any_of(nodes.begin(), nodes.end(),
                     [&](const auto& one) { return one.second["name"] == device; });
}

std::set<std::string> Reports::missing() const {
  std::set<std::string> names;
  for (const std::string& name : named) {
    if (!answered(name) && !lost.contains(name)) names.insert(name);
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

std::string found_there(const Operator& sender) {
  std::string list;
  for (const std::string& name : alive(sender.observer().devices()))
    list += (list.empty() ? "" : ", ") + name;
  const std::string unresolved = sender.unresolved();
  return (list.empty() ? "no device was found there" : "devices found there: " + list) +
         (unresolved.empty() ? "" : "; " + unresolved);
}

Result<Reports> all_reports(Operator& sender, const std::string& wanted) {
  const Nanoseconds limit = sender.search_limit();
  const Instant begin = os::now();
  const Observer& observer = sender.observer();
  const std::set<std::string> devices = wanted.empty() ? std::set<std::string>{} : std::set{wanted};
  if (!sender.search([](const auto& seen) { return !alive(seen).empty(); }, limit, devices)) {
    const std::string unresolved = sender.unresolved();
    const auto silent = sender.silent();
    return fail("no device found on domain " + std::to_string(sender.domain()) + " within " +
                    takt::to_text(std::chrono::floor<std::chrono::seconds>(os::now() - begin)) +
                    (unresolved.empty() ? "" : ": " + unresolved),
                silent.empty() ? "start a node with " + sender.node_command("NAME")
                               : Operator::remedy_of_silence(silent));
  }
  Reports reports;
  std::set<std::string> asked;  // ids of the nodes that were asked for their report
  const auto is_new = [&asked](const wire::ObservedDevice& seen) {
    return seen.alive && !asked.contains(seen.node());
  };
  const auto is_found = [&] {
    return !wanted.empty() && (reports.named.contains(wanted) || !observer.devices(wanted).empty());
  };
  const auto any_new = [&](const std::vector<wire::ObservedDevice>& seen) {
    return is_found() || std::any_of(seen.begin(), seen.end(), is_new);
  };
  Nanoseconds patience{0};
  do {
    std::vector<wire::ObservedDevice> nodes;
    for (wire::ObservedDevice& seen : observer.devices()) {
      if (is_new(seen)) nodes.push_back(std::move(seen));
    }
    for (const wire::ObservedDevice& node : nodes) asked.insert(node.node());
    add_reports(reports, sender, nodes, is_found);
    if (is_found()) break;
    // A device that other devices have lost may come back, so the function then searches for a further
    // kQuiet.
    const bool none_lost = std::all_of(reports.lost.begin(), reports.lost.end(),
                                       [&reports](const auto& lost) { return reports.answered(lost.first); });
    const bool complete = none_lost && reports.complete(observer);
    patience = !reports.missing().empty() ? limit : complete ? Nanoseconds{0} : Nanoseconds{kQuiet};
  } while (patience == limit ? sender.search(any_new, limit, reports.missing())
                             : observer.wait(any_new, patience));
  return reports;
}

}  // namespace takt::client
