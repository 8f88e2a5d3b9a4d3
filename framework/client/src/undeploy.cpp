#include <takt/client/undeploy.hpp>

#include <algorithm>
#include <optional>

#include <takt/client/answer_data.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"
#include "reports.hpp"

namespace takt::client {

namespace {
using json = nlohmann::ordered_json;
}

Result<void> read_undeployed(const std::string& data, Undeployed& one) {
  if (data.empty()) return {};  // the device had no deployment
  return read_answer(one.device, data, [&one](const json& answer) {
    if (const json report = answer.value("report", json{}); !report.is_null())
      one.report = checked_report(report);
    for (const std::string& failure : answer.value("failures", std::vector<std::string>{})) {
      // Equal failure texts are reported only once.
      if (std::find(one.failures.begin(), one.failures.end(), failure) == one.failures.end())
        one.failures.push_back(failure);
    }
  });
}

std::vector<Undeployed> undeploy(Operator& sender, const Devices& devices,
                                 const std::function<void()>& meanwhile) {
  std::vector<CommandRequest> requests;
  for (const std::string& device : devices.names) {
    const auto process = devices.process_ids.find(device);
    requests.push_back({.kind = COMMAND_UNDEPLOY,
                        .device = device,
                        .deployment = devices.deployment,
                        .limit = std::nullopt,
                        .process_id = process == devices.process_ids.end() ? 0 : process->second});
  }
  std::vector<Undeployed> all;
  auto answers = sender.send(requests, [&meanwhile] {
    if (meanwhile) meanwhile();
    return false;
  });
  for (std::size_t i = 0; i < answers.size(); ++i) {
    Undeployed one{.device = devices.names[i]};
    const auto answer = accepted(std::move(answers[i]));
    if (answer) {
      if (const auto read = read_undeployed(answer->data, one); !read) one.problems = read.problems();
    } else {
      one.problems = of_device(one.device, answer.problems());
    }
    all.push_back(std::move(one));
  }
  return all;
}

std::map<std::string, std::vector<std::string>> deployments_of(const std::vector<wire::ObservedDevice>& seen,
                                                               const std::string& cell) {
  std::map<std::string, std::vector<std::string>> found;
  for (const wire::ObservedDevice& one : seen) {
    const std::string id = one.status.deployment().to_string();
    if (one.alive && !id.empty() && (one.status.cell() == cell || id == cell))
      found[id].push_back(one.name());
  }
  return found;
}

CellDevices sort_devices(const std::vector<wire::ObservedDevice>& seen, const std::string& deployment,
                         const std::set<std::string>& whole) {
  CellDevices sorted{.deployment = deployment};
  for (const std::string& name : whole) {
    bool alive = false;
    bool has_it = false;
    bool waits = false;
    for (const wire::ObservedDevice& one : seen) {
      if (!one.alive || one.name() != name) continue;
      alive = true;
      has_it |= one.status.deployment() == deployment;
      waits |= one.status.deployment().size() == 0;
    }
    if (has_it)
      sorted.names.push_back(name);
    else if (waits)
      sorted.waiting.push_back(name);
    else if (!alive)
      sorted.lost.push_back(name);
  }
  return sorted;
}

Result<CellDevices> devices_of(Operator& sender, const std::string& cell) {
  const Observer& observer = sender.observer();
  const Nanoseconds limit = sender.search_limit();
  const std::string domain = "domain " + std::to_string(sender.domain());
  sender.search([&](const auto& seen) { return !deployments_of(seen, cell).empty(); }, limit);
  const auto found = deployments_of(observer.devices(), cell);
  if (found.empty()) {
    std::set<std::string> cells;
    for (const wire::ObservedDevice& seen : observer.devices()) {
      if (seen.alive && seen.status.cell() != std::string{wire::kNoCell})
        cells.insert(seen.status.cell().to_string());
    }
    std::string list;
    for (const std::string& name : cells) list += (list.empty() ? "" : ", ") + name;
    return fail("no device on " + domain + " runs cell " + cell,
                list.empty() ? "no cell runs on this domain" : "cells on this domain: " + list);
  }
  // Each node knows all devices of its cell, and all nodes that it has discovered. Asks one node for these
  // devices and nodes, and then waits until this program has discovered all of them, too.
  const auto& [deployment, first] = *found.begin();
  std::set<std::string> whole;
  std::set<std::string> lost;
  std::set<std::string> nodes;
  Problems unanswered;
  for (const std::string& device : first) {
    const auto answer = accepted(sender.send({.kind = COMMAND_REPORT, .device = device}));
    const auto read = answer ? read_answer(device, answer->data,
                                           [&](const json& report) {
                                             whole = report.at("devices").get<std::set<std::string>>();
                                             lost.clear();
                                             for (const json& other : report.at("lost"))
                                               lost.insert(other.at("name").get<std::string>());
                                             nodes = report.at("heard").get<std::set<std::string>>();
                                           })
                             : Result<void>{answer.problems()};
    if (read) {
      unanswered.clear();
      break;
    }
    unanswered.insert(unanswered.end(), read.problems().begin(), read.problems().end());
  }
  if (!unanswered.empty()) return unanswered;
  whole.insert(first.begin(), first.end());
  observer.wait(
      [&, &id = deployment](const std::vector<wire::ObservedDevice>& seen) {
        std::set<std::string> known;
        for (const wire::ObservedDevice& one : seen) known.insert(one.node());
        const CellDevices sorted = sort_devices(seen, id, whole);
        return std::includes(known.begin(), known.end(), nodes.begin(), nodes.end()) &&
               std::includes(lost.begin(), lost.end(), sorted.lost.begin(), sorted.lost.end());
      },
      limit);
  const auto all = deployments_of(observer.devices(), cell);
  if (all.size() > 1) {
    std::string list;
    for (const auto& [id, names] : all) {
      list += (list.empty() ? "" : ", and ") + id + " on ";
      for (const std::string& name : names) list += (name == names.front() ? "" : ", ") + name;
    }
    return fail(std::to_string(all.size()) + " deployments on " + domain + " are named " + cell + ": " + list,
                "run takt undeploy with the id of the deployment that you want to end");
  }
  return sort_devices(observer.devices(), deployment, whole);
}

}  // namespace takt::client
