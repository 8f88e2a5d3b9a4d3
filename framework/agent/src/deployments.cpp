// Starts a deployment on this device, and ends it.
#include "update.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/wire/words.hpp>
#include "clocks.hpp"
#include "limits.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;
using Phase = Supervised::Phase;

std::string Agent::Deployment::component_of(const std::string& module) const {
  if (cell.devices.empty()) return "";
  const auto& mine = of_device().modules;
  for (std::size_t i = 0; i < std::min(mine.size(), found.builds.size()); ++i) {
    if (mine[i].name != module || found.builds[i].hash.empty()) continue;
    const std::string& path = found.paths.at(i);
    return path.substr(path.rfind('/') + 1) + " " + model::to_text(found.builds[i]);
  }
  return "";
}

nlohmann::ordered_json Agent::Deployment::ports_of(const model::Device& device, const Inspected& found) {
  json modules = json::array();
  for (std::size_t i = 0; i < device.modules.size(); ++i) {
    const bool known = i < found.ports.size() && found.ports[i];
    modules.push_back(
        {{"name", device.modules[i].name},
         {"ports", known ? model::parse_json(model::ports_json(*found.ports[i])) : json(nullptr)}});
  }
  return {{"modules", modules}};
}

void Agent::Deployment::take_t0() {
  if (t0 || !transaction.t0) return;
  t0_ns = transaction.state.t0_ns;
  t0 = transaction.t0;
}

std::unique_ptr<Agent::Deployment> Agent::Deployment::afresh() const {
  auto again = std::make_unique<Deployment>();
  again->id = id;
  again->file = file;
  again->text = text;
  again->require_real_time = require_real_time;
  again->cell = cell;
  again->device = device;
  again->found = found;
  again->swapped = swapped;
  again->set = set;
  again->transaction = transaction;
  again->t0_ns = t0_ns;
  again->t0 = t0;
  again->safe = safe;
  return again;
}

const Agent::Deployment* Agent::present() const {
  if (deployment_) return deployment_.get();
  return update_ && update_->after().has_device() ? &update_->after() : nullptr;
}

Result<bool> Agent::read(Deployment& deployment) const {
  auto cell = factories_.parse(deployment.text, deployment.file);
  if (!cell) return cell.problems();
  deployment.cell = std::move(*cell);
  if (const auto secured = check_security(deployment.cell); !secured) return secured.problems();
  const auto& devices = deployment.cell.devices;
  const auto mine = std::find_if(devices.begin(), devices.end(),
                                 [this](const model::Device& one) { return one.name == options_.device; });
  if (mine == devices.end()) return false;
  deployment.device = static_cast<std::size_t>(mine - devices.begin());
  if (const auto plan = schedule::plan(deployment.cell, *mine); !plan) return plan.problems();
  return true;
}

// Begins a saved deployment again.
void Agent::begin(std::unique_ptr<Deployment> deployment) {
  resuming_ = false;
  last_refusal_.clear();
  drop_gone();
  deployment_ = std::move(deployment);
  const auto has_device = read(*deployment_);
  if (!has_device) return abandon(has_device.problems());
  if (!*has_device)
    return abandon({fail("cell " + deployment_->cell.name + " has no device " + options_.device)});
  if (deployment_->transaction.devices.empty())
    deployment_->transaction.devices = model::device_names(deployment_->cell);
  log("preparing cell " + deployment_->cell.name);
  auto inspection = factories_.inspect({.text = deployment_->text,
                                        .file = deployment_->file,
                                        .device = options_.device,
                                        .as_written = options_.temporary,
                                        .swapped = deployment_->swapped});
  if (!inspection) return abandon(inspection.problems());
  deployment_->inspection = std::move(*inspection);
}

Result<void> Agent::check_security(const model::Cell& cell) const {
  if (cell.security_required && options_.cell.empty()) {
    return fail("cell " + cell.name + " requires security, but the node of device " + options_.device +
                    " runs without it",
                "start the node with --security FOLDER; takt secure creates such folders");
  }
  if (!options_.cell.empty() && options_.cell != cell.name) {
    return fail("the identity of device " + options_.device + " is for cell " + options_.cell +
                    ", not for cell " + cell.name,
                "give the device an identity for that cell");
  }
  return {};
}

void Agent::check_inspection() {
  if (!deployment_ || !deployment_->inspection) return;
  const auto result = deployment_->inspection->result();
  if (!result) return;
  deployment_->inspection.reset();
  if (!*result) {
    abandon(result->problems());
    return;
  }
  deployment_->found = **result;
  bring_up();
}

void Agent::bring_up() {
  Deployment& d = *deployment_;
  for (const model::Module& module : d.of_device().modules) {
    LifecycleStatus status;
    wire::set(status.path(), wire::path_of(d.cell.name, options_.device, module.name));
    wire::set(status.cell(), d.cell.name);
    wire::set(status.device(), options_.device);
    wire::set(status.name(), module.name);
    status.state(STATE_IDLE);
    status.previous_state(STATE_IDLE);
    status.event(EVENT_NONE);
    status.time_ns(options_.wall_ns());
    publisher_.publish(status);
    d.modules.push_back(status);
  }
  model::Cell cell = d.cell;
  for (model::Module& module : cell.devices[d.device].modules) {
    for (const auto& [name, value] : d.set[module.name]) model::give_property(module, name, value);
  }
  d.supervised = factories_.supervise(
      {.cell = std::move(cell),
       .device = d.device,
       .paths = d.found.paths,
       .ports = d.found.ports,
       .require_real_time = d.require_real_time,
       .stepped = [this](const Step& step) { stepped(step); },
       .noted = [this](model::Fault fault, const std::string& origin) { note(std::move(fault), origin); },
       .executes =
           [this](const std::string& device, const std::string& module) {
             return others_.executes(deployment_->cell.name, device, module);
           },
       .is_lost =
           [this](const std::string& device) {
             return device != options_.device && others_.has_lost(device);
           },
       .latest_clock = [this](const std::string& device) -> std::optional<std::int64_t> {
         const auto bounds = clock_of(device);
         return bounds ? std::optional{bounds->high_ns} : std::nullopt;
       }});
  if (const auto prepared = d.supervised->prepare(); !prepared) abandon(prepared.problems());
}

void Agent::stepped(const Step& step) {
  LifecycleStatus& status = deployment_->modules.at(step.module);
  status.state(static_cast<LifecycleState>(step.transition.to));
  status.previous_state(static_cast<LifecycleState>(step.transition.from));
  status.event(static_cast<LifecycleEvent>(static_cast<std::uint32_t>(step.transition.event) + 1));
  status.error(static_cast<LifecycleError>(step.error));
  wire::set(status.text(), step.text);
  status.sequence_number(step.transition.sequence);
  status.time_ns(options_.wall_ns());
  // When this node gives way, the other node has published the states of the device's modules.
  if (!has_given_way_) publisher_.publish(status);
}

// Ends a deployment that has no modules yet, or could not start them.
void Agent::abandon(const Problems& problems) {
  if (update_ && update_->in_transit()) {
    update_->taken_down(problems);
    return;
  }
  if (!deployment_->undeployers.empty() || deployment_->ended_elsewhere) {
    log("cell " + deployment_->cell.name + " is undeployed");
    last_refusal_.clear();
  } else if (!deployment_->over) {
    log("cell " + deployment_->cell.name + " could not be restored: " + in_words(problems));
    last_refusal_ = to_text(problems[0]);
    // The next start of the node restores the cell, unless it is undeployed before.
    deployment_->over = !ending_ && !deployment_->cell.name.empty();
    if (deployment_->over) return;
  }
  for (const Command& undeployer : deployment_->undeployers) answer_when_saved(undeployer, "", "");
  clear();
}

void Agent::step_supervised() {
  if (!deployment_ || !deployment_->supervised || deployment_->over) return;
  deployment_->supervised->step();
  switch (deployment_->supervised->phase()) {
    case Phase::preparing:
    case Phase::running:
      break;
    case Phase::ready:
      if (update_ && update_->is_after() && !update_->is_undoing()) break;  // it begins at T0
      go();
      if (!update_)
        keep_for_restart();
      else if (update_->in_transit())
        update_->undone();
      break;
    case Phase::stopping:
      if (update_) update_->device_fails(deployment_->supervised->failures());
      break;
    case Phase::ended:
      if (update_) update_->device_fails(deployment_->supervised->failures());
      finish();
      break;
  }
}

void Agent::go() {
  Deployment& d = *deployment_;
  d.supervised->give_safe(model::parse_safe(d.safe));
  d.supervised->go(*d.t0);
  d.began = true;
  std::string components;
  for (const model::Module& module : d.of_device().modules) {
    const std::string component = d.component_of(module.name);
    if (!component.empty()) components += (components.empty() ? ": " : ", ") + component;
  }
  note({.kind = model::FaultKind::deployed,
        .cause = "cell " + d.cell.name + " runs, from " + d.file + components});
}

// Ends the deployment without a command.
void Agent::take_back(const std::string& why) {
  if (update_) update_->drop(why, was_undeployed(update_->after().id));
  if (!deployment_) return;
  deployment_->undone = why;
  if (!deployment_->supervised)
    abandon({fail(why)});
  else if (deployment_->over)
    finish();
  else
    stop();
}

// Ends the deployment if another device of the cell has undeployed it. This device may have missed the
// command, because it was lost then, or because the operator was lost before sending the command to all
// devices.
void Agent::check_undeployed() {
  const Deployment* const d = present() != nullptr ? present() : gone_.get();
  if (d == nullptr || !d->undeployers.empty() || ending_) return;
  for (const model::Device& device : d->cell.devices) {
    if (device.name == options_.device) continue;
    for (const auto& [status, alive] : others_.of_device(device.name)) {
      if (!alive || status.undeployed() != d->id) continue;
      if (d == gone_.get()) return remember_undeployed(d->id);
      if (d->ended_elsewhere) return;
      if (deployment_) deployment_->ended_elsewhere = true;
      remember_undeployed(d->id);
      if (!d->undone.empty()) return;
      const std::string why = "it was undeployed on device " + device.name;
      log("cell " + d->cell.name + " ends: " + why);
      return take_back(why);
    }
  }
}

bool Agent::was_undeployed(const std::string& id) const {
  return std::find(undeployed_.begin(), undeployed_.end(), id) != undeployed_.end();
}

// Also forgets the saved deployment, if it was undeployed.
void Agent::remember_undeployed(const std::string& id) {
  if (was_undeployed(id)) return;
  undeployed_.push_back(id);
  if (undeployed_.size() > kUndeployedKept) undeployed_.erase(undeployed_.begin());
  if (gone_ && gone_->id == id) gone_.reset();
  keep_for_restart();
}

// Returns the id of an undeployed deployment that another device still has, or that still ends on this
// device.
std::string Agent::undeployed_but_held() const {
  for (const std::string& id : undeployed_) {
    const auto others = others_.of_deployment(id, options_.device);
    const bool held =
        std::any_of(others.begin(), others.end(), [](const auto& other) { return other.alive; });
    if (held || (deployment_ && deployment_->id == id)) return id;
  }
  return "";
}

void Agent::undeploy(const Command& command) {
  const std::string id = command.deployment().to_string();
  const Deployment* const mine = deployment_ ? deployment_.get() : update_ ? &update_->after() : nullptr;
  if (mine != nullptr && !id.empty() && mine->id != id) {
    remember_undeployed(id);
    return answer_when_saved(
        command, "device " + options_.device + " has another deployment, of cell " + mine->cell.name, "");
  }
  if (update_) update_->drop("it was undeployed", true);
  if (!deployment_) {
    resuming_ = false;
    if (!id.empty()) remember_undeployed(id);
    drop_gone();
    keep_for_restart();  // removes also a saved deployment that was not restored
    last_refusal_.clear();
    answer_when_saved(command, "device " + options_.device + " has no deployment",
                      !id.empty() && id == last_id_ ? last_data_ : "");
    return;
  }
  deployment_->undeployers.push_back(command);
  // `takt run` uses this command also to fetch the report of a device that has ended while the others
  // continue.
  if (!deployment_->over || !options_.temporary)
    remember_undeployed(deployment_->id);
  else
    gone_.reset();
  if (!deployment_->supervised) {
    abandon({fail("it was undeployed")});
  } else if (deployment_->over) {
    finish();
  } else {
    stop();
  }
}

// Stops the device. A device that has failed before stops already.
void Agent::stop() {
  deployment_->stopped = deployment_->supervised->phase() < Phase::stopping;
  deployment_->supervised->stop();
}

// Records the end of the deployment, and answers the waiting commands. Called when a failure or a command has
// ended the deployment.
void Agent::finish() {
  Deployment& d = *deployment_;
  const Problems failures = d.supervised->failures();
  const std::vector<Command> undeployers = std::move(d.undeployers);
  const bool in_transit = update_ && update_->in_transit();
  ended_at_ = options_.now();
  nlohmann::ordered_json texts = nlohmann::ordered_json::array();
  for (const Problem& problem : failures) texts.push_back(to_text(problem));
  // An operator has undeployed the cell, and another device received the command earlier. This is no failure.
  const bool passed_on = d.ended_elsewhere;
  // A device that has undone the deployment first reports the reason.
  if (!d.undone.empty() && !passed_on && !d.undone_elsewhere &&
      (failures.empty() || d.undone != in_words({failures[0]})))
    texts.push_back(to_text(Problem{"device " + options_.device, d.undone, ""}));
  last_id_ = d.id;
  last_data_ = model::json_text({{"report", d.supervised->report()}, {"failures", texts}});
  if (!d.began && !in_transit && undeployers.empty() && !failures.empty())
    last_refusal_ = to_text(failures[0]);

  filter_.flush();
  const bool forward = d.replaced && failures.empty() && undeployers.empty() && !passed_on && !ending_;
  // Until an update is complete, the cell runs on; then the update records itself.
  const bool goes_on =
      forward || (in_transit && (failures.empty() || d.stopped) && update_->before() != nullptr);
  // A module that was given up before has not ended the cell, if an operator or the node has stopped it.
  if (d.began && !d.over && !goes_on) {
    note({.kind = model::FaultKind::undeployed,
          .cause = "cell " + d.cell.name + " has ended" +
                   (!failures.empty() && !d.stopped     ? ": " + in_words({failures[0]})
                    : !undeployers.empty() || passed_on ? ": it was undeployed"
                    : !d.undone.empty()                 ? ": " + d.undone
                    : ending_                           ? ": its node is shutting down"
                                                        : "")});
  }
  devices_seen_.clear();
  if (in_transit) {
    update_->taken_down(failures);
    return;
  }
  if (forward) {
    clear();
    return go_forward();
  }
  if (undeployers.empty() && d.began && d.undone.empty()) {
    d.over = true;
    if (update_) update_->device_ended(failures, d.supervised->stops_cell());
    return;
  }
  if (!undeployers.empty() || passed_on) log("cell " + d.cell.name + " is undeployed");
  clear();
  publish_status();  // before the answers, so that a client with an answer sees that the device is free
  for (const Command& undeployer : undeployers) answer_when_saved(undeployer, "", last_data_);
}

void Agent::clear() {
  if (!deployment_->describers.empty()) described(fail("the deployment ended before it was described"));
  if (deployment_->swap) answer(*deployment_->swap, REPLY_FAILED, "the device is stopping");
  if (deployment_->supervised && !deployment_->modules.empty() && !has_given_way_)
    publisher_.withdraw(deployment_->modules, deployment_->supervised->measures());
  deployment_.reset();
}

}  // namespace takt::agent
