#include <takt/client/deploy.hpp>

#include <algorithm>
#include <set>

#include <takt/core/words.hpp>
#include <takt/os/clock.hpp>
#include <takt/wire/words.hpp>
#include "answers.hpp"
#include "coordinator.hpp"
#include "reports.hpp"

namespace takt::client {

namespace {

// When to show which devices are not found yet: not at once, and not again for each device.
constexpr Nanoseconds kUsuallyFound = std::chrono::milliseconds{300};
constexpr Nanoseconds kShowEvery = std::chrono::seconds{1};

class Deployment {
 public:
  Deployment(Operator& sender, const model::Cell& cell, const DeployOptions& options)
      : sender_(sender), cell_(cell), options_(options), coordinator_(sender, plan_of(cell, options)) {}

  Problems find();
  Problems start(const std::string& text);
  /// Ends the deployment on all devices, and adds the reasons that the devices give to `problems`.
  Problems undo(Problems problems);
  [[nodiscard]] Deployed deployed() const {
    return {.id = coordinator_.plan().id,
            .t0_ns = coordinator_.t0_ns(),
            .failed_modules = options_.process_ids.empty() ? coordinator_.failed_modules() : Problems{}};
  }

 private:
  static Plan plan_of(const model::Cell& cell, const DeployOptions& options) {
    const std::string id = new_id();
    return {.cell = cell,
            .name = "deployment",
            .id = id,
            .deployment = id,
            .devices = model::device_names(cell),
            .process_ids = options.process_ids,
            .progress = options.progress,
            .cancelled = options.cancelled};
  }

  Operator& sender_;
  const model::Cell& cell_;
  const DeployOptions& options_;
  Coordinator coordinator_;
};

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
  std::set<std::string> shown;
  Instant show_at = os::now() + kUsuallyFound;
  std::set<std::string> wanted;
  for (const model::Device& device : cell_.devices) wanted.insert(device.name);
  sender_.search(
      [&](const std::vector<wire::ObservedDevice>& devices) {
        std::set<std::string> now;
        for (const model::Device& device : cell_.devices) {
          const auto found = nodes(devices, device);
          if (std::none_of(found.begin(), found.end(), expected)) now.insert(device.name);
        }
        if (now != shown && !now.empty() && os::now() >= show_at) {
          std::string names;
          for (const std::string& name : now) names += (names.empty() ? "" : ", ") + name;
          coordinator_.show_progress((now.size() == 1 ? "waiting for device " : "waiting for devices ") +
                                     names);
          shown = now;
          show_at = os::now() + kShowEvery;
        }
        return now.empty() || coordinator_.cancelled();
      },
      std::max(options_.discovery, sender_.search_limit()), wanted);
  if (coordinator_.cancelled()) return {fail("the deployment was cancelled before all devices were found")};

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
      const std::string remedy = sender_.remedy_of_silence(device.name);
      problems.push_back({where, "not found on " + domain,
                          !remedy.empty() ? remedy
                                          : (meant.empty() ? "" : "did you mean " + meant + "? Otherwise ") +
                                                "start its node with " + sender_.node_command(device.name) +
                                                "; " + found_there(sender_)});
    } else if (found.size() > 1) {
      std::vector<DeviceStatus> all;
      for (const wire::ObservedDevice& seen : found) all.push_back(seen.status);
      problems.push_back({where, wire::nodes_of_one_name(all, sender_.domain()),
                          "end all but one of them, or use another domain"});
    } else if (!expected(found[0])) {
      problems.push_back({where, "another node on " + domain + " has this name", "use another domain"});
    } else if (found[0].status.cell() != std::string{wire::kNoCell}) {
      const std::string cell = found[0].status.cell().to_string();
      const DeviceState state = found[0].status.state();
      const bool prepares = state == DEVICE_PREPARING || state == DEVICE_READY || state == DEVICE_ARMED ||
                            state == DEVICE_STARTED;
      std::string fix = (prepares ? "wait for it, or run takt undeploy " : "run takt undeploy ") + cell +
                        (prepares ? "" : " first");
      if (state == DEVICE_RUNNING && cell == cell_.name)
        fix += "; or run takt deploy --update to change the cell while it runs";
      problems.push_back({where,
                          state == DEVICE_ENDED ? "it still holds cell " + cell + ", which has ended"
                          : prepares            ? "it is already preparing cell " + cell
                                                : "it already runs cell " + cell,
                          fix});
    }
  }
  return problems;
}

Problems Deployment::start(const std::string& text) {
  coordinator_.show_progress("preparing " + std::to_string(cell_.devices.size()) +
                             (cell_.devices.size() == 1 ? " device" : " devices"));
  Problems problems = coordinator_.prepare(text);
  if (problems.empty()) problems = coordinator_.change(0, options_.require_real_time);
  return problems.empty() ? coordinator_.run() : problems;
}

Problems Deployment::undo(Problems problems) {
  coordinator_.show_progress("undoing the deployment");
  Devices devices{
      .names = {}, .process_ids = options_.process_ids, .deployment = coordinator_.plan().deployment};
  std::vector<Undeployed> unreached;
  for (const std::string& device : coordinator_.plan().devices) {
    if (coordinator_.is_alive(device))
      devices.names.push_back(device);
    else if (coordinator_.change_sent())
      unreached.push_back({.device = device,
                           .problems = {{"device " + device, "it is lost, so its state is not known", ""}}});
  }
  auto undone = undeploy(sender_, devices, [this] { static_cast<void>(coordinator_.cancelled()); });
  undone.insert(undone.end(), unreached.begin(), unreached.end());
  for (Undeployed& one : undone) {
    if (!coordinator_.change_sent()) one.problems.clear();  // so the device has only checked the descriptor
    if (!coordinator_.run_sent()) continue;  // without T0, the device undoes by itself what it has prepared
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
  if (Problems problems = deployment.start(text); !problems.empty())
    return deployment.undo(std::move(problems));
  return deployment.deployed();
}

}  // namespace takt::client
