#include <takt/client/deploy.hpp>

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include <takt/wire/words.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include "answers.hpp"

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

class Deployment {
 public:
  Deployment(Operator& asker, const model::Cell& cell, const DeployOptions& options)
      : asker_(asker), cell_(cell), options_(options), id_(new_id()) {}

  Problems find();
  Problems prepare(const std::string& text);
  Problems run(std::int64_t t0_ns);
  void undo();
  [[nodiscard]] const std::string& id() const noexcept { return id_; }

 private:
  [[nodiscard]] bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  void show_progress(const std::string& text) const {
    if (options_.progress) options_.progress(text);
  }
  Question question(CommandKind kind, const std::string& device) const;
  // Sends the questions to the devices. Returns the problems of the devices that did not answer with
  // REPLY_OK.
  Problems ask(const std::vector<Question>& questions, std::vector<wire::WholeReply>* replies = nullptr);

  Operator& asker_;
  const model::Cell& cell_;
  const DeployOptions& options_;
  std::string id_;
  std::string safe_;  // the safe values of all outputs of the cell, as JSON; each device gets them, because
                      // it knows only its own
  KeepAlive keep_alive_;
};

Question Deployment::question(CommandKind kind, const std::string& device) const {
  Question question{.kind = kind, .device = device, .deployment = id_};
  const auto process = options_.process_ids.find(device);
  if (process != options_.process_ids.end()) question.process_id = process->second;
  return question;
}

Problems Deployment::ask(const std::vector<Question>& questions, std::vector<wire::WholeReply>* replies) {
  Problems problems;
  std::vector<std::string> names;
  for (const model::Device& device : cell_.devices) names.push_back(device.name);
  keep_alive_.sent();
  auto answers = asker_.ask(questions, [&] {
    keep_alive_.send(asker_, names,
                     [this](CommandKind kind, const std::string& name) { return question(kind, name); });
    return cancelled();
  });
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer && replies != nullptr) replies->push_back(*answer);
    if (answer) continue;
    const Problems reasons = of_device(questions[i].device, answer.problems());
    problems.insert(problems.end(), reasons.begin(), reasons.end());
  }
  if (cancelled()) return {fail("cancelled before all devices were ready")};
  return problems;
}

// Finds the node of each device. Each device must have exactly one node, and the node must not have a
// deployment.
Problems Deployment::find() {
  const auto nodes = [](const std::vector<wire::ObservedDevice>& devices, const model::Device& device) {
    std::vector<wire::ObservedDevice> found;
    for (const wire::ObservedDevice& seen : devices) {
      if (seen.alive && seen.name() == device.name) found.push_back(seen);
    }
    return found;
  };
  const auto expected = [this](const wire::ObservedDevice& seen) {
    const auto process = options_.process_ids.find(seen.name());
    return process == options_.process_ids.end() || process->second == seen.status.process_id();
  };
  std::set<std::string> missing;
  asker_.observer().wait(
      [&](const std::vector<wire::ObservedDevice>& devices) {
        std::set<std::string> now;
        for (const model::Device& device : cell_.devices) {
          const auto found = nodes(devices, device);
          if (std::none_of(found.begin(), found.end(), expected)) now.insert(device.name);
        }
        if (now != missing && !now.empty()) {
          std::string names;
          for (const std::string& name : now) names += (names.empty() ? "" : ", ") + name;
          show_progress("waiting for " + names);
        }
        missing = now;
        return missing.empty() || cancelled();
      },
      std::max(options_.discovery, asker_.search_limit()));
  if (cancelled()) return {fail("cancelled before all devices were found")};

  Problems problems;
  const auto devices = asker_.observer().devices();
  const std::string domain = "domain " + std::to_string(asker_.domain());
  for (const model::Device& device : cell_.devices) {
    const std::string where = "device " + device.name;
    const auto found = nodes(devices, device);
    if (found.empty()) {
      problems.push_back({where, "not found on " + domain,
                          "start its node with takt-node --device " + device.name + " --domain " +
                              std::to_string(asker_.domain())});
    } else if (found.size() > 1) {
      std::string places;
      for (const wire::ObservedDevice& seen : found) {
        places += (places.empty() ? "process " : ", process ") + std::to_string(seen.status.process_id()) +
                  " on " + seen.status.host_name().to_string();
      }
      problems.push_back({where,
                          std::to_string(found.size()) + " nodes on " + domain + " have this name: " + places,
                          "end all but one of them, or use another domain"});
    } else if (!expected(found[0])) {
      problems.push_back({where, "another node on " + domain + " has this name", "use another domain"});
    } else if (found[0].status.cell() != std::string{wire::kNoCell}) {
      const std::string cell = found[0].status.cell().to_string();
      const bool over = found[0].status.state() == DEVICE_ENDED;
      std::string fix = "run takt undeploy " + cell + " first";
      if (!over && cell == cell_.name)
        fix += "; or run takt deploy --update to change the cell while it runs";
      problems.push_back(
          {where, over ? "it still holds cell " + cell + ", which has ended" : "it already runs cell " + cell,
           fix});
    }
  }
  return problems;
}

Problems Deployment::prepare(const std::string& text) {
  show_progress("preparing " + std::to_string(cell_.devices.size()) +
                (cell_.devices.size() == 1 ? " device" : " devices"));
  std::vector<Question> questions;
  for (const model::Device& device : cell_.devices) {
    Question q = question(COMMAND_PREPARE, device.name);
    q.property = options_.require_real_time ? wire::kRequireRealTime : "";
    q.value = wire::cut(cell_.file, 255);
    q.data = text;
    q.limit.reset();
    questions.push_back(std::move(q));
  }
  std::vector<wire::WholeReply> replies;
  if (Problems problems = ask(questions, &replies); !problems.empty()) return problems;
  const model::CellPorts ports = ports_of(cell_, replies);
  safe_ = model::safe_json(model::safe_outputs(cell_, ports));
  return model::check_connections(cell_, ports);
}

Problems Deployment::run(std::int64_t t0_ns) {
  std::vector<Question> questions;
  for (const model::Device& device : cell_.devices) {
    Question q = question(COMMAND_RUN, device.name);
    q.time_ns = t0_ns;
    q.data = safe_;
    const Nanoseconds left = Nanoseconds{t0_ns - wall_ns()} - options_.margin;
    q.limit = std::max(std::chrono::floor<std::chrono::milliseconds>(left), std::chrono::milliseconds{1});
    questions.push_back(std::move(q));
  }
  return ask(questions);
}

void Deployment::undo() {
  show_progress("undoing the deployment");
  Devices devices{.names = {}, .process_ids = options_.process_ids, .deployment = id_};
  for (const model::Device& device : cell_.devices) {
    // A device without a live node has nothing to undo, so it is not asked.
    const auto seen = asker_.observer().devices(device.name);
    if (std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& s) { return s.alive; }))
      devices.names.push_back(device.name);
  }
  auto undone = undeploy(asker_, devices, [this] { static_cast<void>(cancelled()); });
  if (options_.undone != nullptr) *options_.undone = std::move(undone);
}

}  // namespace

Result<Deployed> deploy(Operator& asker, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options) {
  if (text.size() > wire::kMaxData)
    return fail("the descriptor is larger than " + std::to_string(wire::kMaxData >> 20U) + " MiB",
                "make it smaller");
  Deployment deployment{asker, cell, options};
  if (Problems problems = deployment.find(); !problems.empty()) return problems;
  if (Problems problems = deployment.prepare(text); !problems.empty()) {
    deployment.undo();
    return problems;
  }
  const std::int64_t t0_ns = wall_ns() + options.lead.count();
  if (Problems problems = deployment.run(t0_ns); !problems.empty()) {
    deployment.undo();
    return problems;
  }
  return Deployed{.id = deployment.id(), .t0_ns = t0_ns};
}

std::vector<Undeployed> undeploy(Operator& asker, const Devices& devices,
                                 const std::function<void()>& meanwhile) {
  std::vector<Question> questions;
  for (const std::string& device : devices.names) {
    const auto process = devices.process_ids.find(device);
    questions.push_back({.kind = COMMAND_UNDEPLOY,
                         .device = device,
                         .deployment = devices.deployment,
                         .limit = std::nullopt,
                         .process_id = process == devices.process_ids.end() ? 0 : process->second});
  }
  std::vector<Undeployed> all;
  auto answers = asker.ask(questions, [&meanwhile] {
    if (meanwhile) meanwhile();
    return false;
  });
  for (std::size_t i = 0; i < answers.size(); ++i) {
    Undeployed one{.device = devices.names[i]};
    const auto answer = accepted(std::move(answers[i]));
    if (answer) {
      const json data = model::parse_json(answer->data);
      if (data.is_object()) {
        one.report = data.value("report", json{});
        for (const std::string& failure : data.value("failures", std::vector<std::string>{})) {
          // Equal failure texts are reported only once.
          if (std::find(one.failures.begin(), one.failures.end(), failure) == one.failures.end())
            one.failures.push_back(failure);
        }
      }
    } else {
      one.problems = of_device(one.device, answer.problems());
    }
    all.push_back(std::move(one));
  }
  return all;
}

Result<CellDevices> devices_of(Operator& asker, const std::string& cell) {
  const Observer& observer = asker.observer();
  const auto of_cell = [&cell](const std::vector<wire::ObservedDevice>& devices) {
    std::set<std::string> names;
    for (const wire::ObservedDevice& seen : devices) {
      if (seen.alive && seen.status.cell() == cell) names.insert(seen.name());
    }
    return names;
  };
  const Nanoseconds limit = asker.search_limit();
  observer.wait([&](const auto& devices) { return !of_cell(devices).empty(); }, limit);
  std::set<std::string> names = of_cell(observer.devices());
  if (names.empty()) {
    std::set<std::string> cells;
    for (const wire::ObservedDevice& seen : observer.devices()) {
      if (seen.alive && seen.status.cell() != std::string{wire::kNoCell})
        cells.insert(seen.status.cell().to_string());
    }
    std::string list;
    for (const std::string& name : cells) list += (list.empty() ? "" : ", ") + name;
    return fail("no device on domain " + std::to_string(asker.domain()) + " runs cell " + cell,
                list.empty() ? "no cell runs on this domain" : "cells on this domain: " + list);
  }
  // Each device knows all devices of its cell. Asks the first one, then waits for those that are alive but
  // not discovered yet.
  const auto answer = accepted(asker.ask({.kind = COMMAND_REPORT, .device = *names.begin()}));
  std::set<std::string> lost;
  if (answer) {
    const json report = model::parse_json(answer->data);
    std::set<std::string> whole;
    if (report.is_object()) {
      for (const json& device : report.value("lost", json::array())) lost.insert(device.value("name", ""));
      for (const json& device : report.value("devices", json::array()))
        whole.insert(device.get<std::string>());
    }
    for (const std::string& name : lost) whole.erase(name);
    observer.wait(
        [&](const auto& devices) {
          const auto found = of_cell(devices);
          return std::includes(found.begin(), found.end(), whole.begin(), whole.end());
        },
        limit);
    names = of_cell(observer.devices());
  }
  for (const std::string& name : names) lost.erase(name);
  return CellDevices{.names = {names.begin(), names.end()}, .lost = {lost.begin(), lost.end()}};
}

}  // namespace takt::client
