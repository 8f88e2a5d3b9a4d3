#include <takt/client/deploy.hpp>

#include <algorithm>
#include <optional>
#include <set>

#include <nlohmann/json.hpp>

#include <takt/client/answer_data.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"
#include "decision.hpp"
#include "reports.hpp"

namespace takt::client {

namespace {

using json = nlohmann::ordered_json;

class Deployment {
 public:
  Deployment(Operator& sender, const model::Cell& cell, const DeployOptions& options)
      : sender_(sender), cell_(cell), options_(options), id_(new_id()) {}

  Problems find();
  Problems prepare(const std::string& text);
  Problems connect();
  Problems run(std::int64_t t0_ns);
  [[nodiscard]] Problems wait_until_all_run(std::int64_t t0_ns) const;
  /// Ends the deployment on all devices, and adds the reasons that the devices give to `problems`.
  Problems undo(Problems problems);
  [[nodiscard]] const std::string& id() const noexcept { return id_; }

 private:
  [[nodiscard]] bool cancelled() const { return options_.cancelled && options_.cancelled(); }
  void show_progress(const std::string& text) const {
    if (options_.progress) options_.progress(text);
  }
  CommandRequest request(CommandKind kind, const std::string& device) const;
  // Sends the requests to the devices, and stores the answers with REPLY_OK in `replies`. Returns the
  // problems of all other devices.
  Problems send(const std::vector<CommandRequest>& requests,
                std::vector<wire::WholeReply>* replies = nullptr);

  Operator& sender_;
  const model::Cell& cell_;
  const DeployOptions& options_;
  std::string id_;
  std::string safe_;  // safe values of all outputs of the cell, as JSON; each device gets all values, because
                      // it knows only its own
  KeepAlive keep_alive_;
  bool run_sent_ = false;
};

CommandRequest Deployment::request(CommandKind kind, const std::string& device) const {
  CommandRequest request{.kind = kind, .device = device, .deployment = id_};
  const auto process = options_.process_ids.find(device);
  if (process != options_.process_ids.end()) request.process_id = process->second;
  return request;
}

Problems Deployment::send(const std::vector<CommandRequest>& requests,
                          std::vector<wire::WholeReply>* replies) {
  Problems problems;
  std::vector<std::string> names;
  for (const model::Device& device : cell_.devices) names.push_back(device.name);
  keep_alive_.sent();
  auto answers = sender_.send(requests, [&] {
    keep_alive_.send(sender_, names,
                     [this](CommandKind kind, const std::string& name) { return request(kind, name); });
    return cancelled();
  });
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const auto answer = accepted(std::move(answers[i]));
    if (answer && replies != nullptr) replies->push_back(*answer);
    if (answer) continue;
    const Problems reasons = of_device(requests[i].device, answer.problems());
    problems.insert(problems.end(), reasons.begin(), reasons.end());
  }
  if (cancelled())
    return {fail(run_sent_ ? "cancelled before all devices ran" : "cancelled before all devices were ready")};
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
  sender_.observer().wait(
      [&](const std::vector<wire::ObservedDevice>& devices) {
        std::set<std::string> now;
        for (const model::Device& device : cell_.devices) {
          const auto found = nodes(devices, device);
          if (std::none_of(found.begin(), found.end(), expected)) now.insert(device.name);
        }
        if (now != missing && !now.empty()) {
          std::string names;
          for (const std::string& name : now) names += (names.empty() ? "" : ", ") + name;
          show_progress((now.size() == 1 ? "waiting for device " : "waiting for devices ") + names);
        }
        missing = now;
        return missing.empty() || cancelled();
      },
      std::max(options_.discovery, sender_.search_limit()));
  if (cancelled()) return {fail("cancelled before all devices were found")};

  Problems problems;
  const auto devices = sender_.observer().devices();
  const std::string domain = "domain " + std::to_string(sender_.domain());
  std::set<std::string> others = alive(devices);  // the nodes that are not for a device of this cell
  for (const model::Device& device : cell_.devices) others.erase(device.name);
  for (const model::Device& device : cell_.devices) {
    const std::string where = "device " + device.name;
    const auto found = nodes(devices, device);
    if (found.empty()) {
      const std::string meant{nearest(device.name, {others.begin(), others.end()})};
      problems.push_back({where, "not found on " + domain,
                          (meant.empty() ? "" : "did you mean " + meant + "? Otherwise ") +
                              "start its node with " + sender_.node_command(device.name) + "; " +
                              found_there(devices)});
    } else if (found.size() > 1) {
      std::vector<DeviceStatus> all;
      for (const wire::ObservedDevice& seen : found) all.push_back(seen.status);
      problems.push_back({where, wire::nodes_of_one_name(all, sender_.domain()),
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
  std::vector<CommandRequest> requests;
  for (const model::Device& device : cell_.devices) {
    CommandRequest q = request(COMMAND_PREPARE, device.name);
    q.property = options_.require_real_time ? wire::kRequireRealTime : "";
    q.value = wire::cut(cell_.file, 255);
    q.data = text;
    q.limit.reset();
    requests.push_back(std::move(q));
  }
  std::vector<wire::WholeReply> replies;
  if (Problems problems = send(requests, &replies); !problems.empty()) return problems;
  const auto ports = ports_of(cell_, replies);
  if (!ports) return ports.problems();
  safe_ = model::safe_json(model::safe_outputs(cell_, *ports));
  return model::check_connections(cell_, *ports);
}

// Sends each device the safe values, and waits until the ports of different devices are connected. Each
// device has prepared the cell before, so no device waits for the ports of a device that failed. Afterwards
// each device has everything that it needs, and can also receive T0 from another device.
Problems Deployment::connect() {
  std::vector<CommandRequest> requests;
  for (const model::Device& device : cell_.devices) {
    CommandRequest q = request(COMMAND_CONNECT, device.name);
    q.data = safe_;
    q.limit.reset();
    requests.push_back(std::move(q));
  }
  return send(requests);
}

Problems Deployment::run(std::int64_t t0_ns) {
  std::vector<CommandRequest> requests;
  for (const model::Device& device : cell_.devices) {
    CommandRequest q = request(COMMAND_RUN, device.name);
    q.time_ns = t0_ns;
    q.limit = time_to_confirm(t0_ns);
    requests.push_back(std::move(q));
  }
  run_sent_ = true;
  return send(requests);
}

// Waits until each device is final. From then on no device undoes the deployment.
Problems Deployment::wait_until_all_run(std::int64_t t0_ns) const {
  std::vector<std::string> names;
  for (const model::Device& device : cell_.devices) names.push_back(device.name);
  Problems problems;
  const auto stands =
      wait_until_decided(sender_.observer(), names, {.id = id_, .deployment = id_, .t0_ns = t0_ns},
                         [this] { return cancelled(); });
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::string where = "device " + names[i];
    switch (stands[i]) {
      case Stands::final:
        break;
      case Stands::undecided:
        problems.push_back({where, "it has not heard that all other devices run", "check the network"});
        break;
      case Stands::lost:
        problems.push_back({where, "it was lost before it ran", "check its machine and network"});
        break;
      case Stands::undone:
        problems.push_back({where, "it did not start", ""});
        break;
    }
  }
  if (!problems.empty() && cancelled()) return {fail("cancelled before all devices ran")};
  return problems;
}

Problems Deployment::undo(Problems problems) {
  show_progress("undoing the deployment");
  Devices devices{.names = {}, .process_ids = options_.process_ids, .deployment = id_};
  std::vector<Undeployed> unreached;
  for (const model::Device& device : cell_.devices) {
    // A device without a live node gets no command. If T0 was sent, the state of such a device is not known.
    // Otherwise the device cannot start, and nothing is reported.
    const auto seen = sender_.observer().devices(device.name);
    if (std::any_of(seen.begin(), seen.end(), [](const wire::ObservedDevice& s) { return s.alive; }))
      devices.names.push_back(device.name);
    else if (run_sent_)
      unreached.push_back(
          {.device = device.name,
           .problems = {{"device " + device.name, "it is lost, so its state is not known", ""}}});
  }
  auto undone = undeploy(sender_, devices, [this] { static_cast<void>(cancelled()); });
  undone.insert(undone.end(), unreached.begin(), unreached.end());
  for (Undeployed& one : undone) {
    if (!run_sent_) {
      one.problems.clear();  // without T0 the device cannot start, and undoes its preparation by itself
      continue;
    }
    problems.insert(problems.end(), one.problems.begin(), one.problems.end());
    for (const std::string& failure : one.failures) {
      const std::string where = "device " + one.device;
      const bool placed = failure.starts_with(where + ": error: ");
      problems.push_back({where, placed ? failure.substr(where.size() + 9) : failure, ""});
    }
  }
  if (options_.undone != nullptr) *options_.undone = std::move(undone);
  return problems;
}

}  // namespace

Result<Deployed> deploy(Operator& sender, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options) {
  if (text.size() > wire::kMaxData)
    return fail("the descriptor is larger than " + std::to_string(wire::kMaxData >> 20U) + " MiB",
                "make it smaller");
  Deployment deployment{sender, cell, options};
  if (Problems problems = deployment.find(); !problems.empty()) return problems;
  if (Problems problems = deployment.prepare(text); !problems.empty())
    return deployment.undo(std::move(problems));
  const auto sent = std::chrono::steady_clock::now();
  if (Problems problems = deployment.connect(); !problems.empty())
    return deployment.undo(std::move(problems));
  const Nanoseconds took = std::chrono::steady_clock::now() - sent;
  const std::int64_t t0_ns = choose_t0(took);
  if (Problems problems = deployment.run(t0_ns); !problems.empty())
    return deployment.undo(std::move(problems));
  if (Problems problems = deployment.wait_until_all_run(t0_ns); !problems.empty())
    return deployment.undo(std::move(problems));
  return Deployed{.id = deployment.id(), .t0_ns = t0_ns};
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
  observer.wait([&](const auto& seen) { return !deployments_of(seen, cell).empty(); }, limit);
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
      [&, &deployment = deployment](const std::vector<wire::ObservedDevice>& seen) {
        std::set<std::string> known;
        for (const wire::ObservedDevice& one : seen) known.insert(one.node());
        const CellDevices sorted = sort_devices(seen, deployment, whole);
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
