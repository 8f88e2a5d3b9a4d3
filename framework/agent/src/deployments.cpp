// Carries out the commands prepare, run and undeploy, and saves and restores the deployment.
#include "update.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/agent/problems_json.hpp>
#include <takt/core/span.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/wire/words.hpp>
#include "clocks.hpp"
#include "limits.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;
using Phase = Supervised::Phase;
using transaction::Stage;

namespace {

// A cell, and the index of this device in it.
struct Found {
  model::Cell cell;
  std::size_t device;
};
// Finds a device in the text of a descriptor. Also plans the device's schedule, so that no later step can
// fail because there is no schedule.
Result<Found> find_device(const std::string& text, const std::string& file, const std::string& name) {
  auto cell = descriptor::parse(text, file);
  if (!cell) return cell.problems();
  const auto device = std::find_if(cell->devices.begin(), cell->devices.end(),
                                   [&](const model::Device& d) { return d.name == name; });
  if (device == cell->devices.end()) {
    return Problem{file, "cell " + cell->name + " has no device " + name,
                   "deploy the cell only to its own devices"};
  }
  if (const auto plan = schedule::plan(*cell, *device); !plan) return plan.problems();
  const auto index = static_cast<std::size_t>(device - cell->devices.begin());
  return Found{std::move(*cell), index};
}

}  // namespace

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

// Returns why the device cannot accept a new deployment now.
std::string Agent::occupied() const {
  const std::string cell = " cell " + deployment_->cell.name;
  const std::string device = "device " + options_.device;
  if (deployment_->over) return device + " still holds" + cell + ", which has ended";
  if (!deployment_->supervised || deployment_->supervised->phase() == Phase::preparing)
    return device + " is already preparing" + cell + "; wait for it, or undeploy it";
  if (deployment_->supervised->phase() == Phase::stopping)
    return device + " is shutting down" + cell + "; try again later";
  return device + " already runs" + cell + "; undeploy it first";
}

void Agent::prepare(const wire::WholeCommand& command) {
  const Command& head = command.head;
  const std::string id = head.deployment().to_string();
  if (ending_) {
    answer(head, REPLY_REFUSED, "the node of device " + options_.device + " is shutting down");
    return;
  }
  if (update_) {
    answer(head, REPLY_REFUSED, "device " + options_.device + " is being updated; try again later");
    return;
  }
  if ((gone_ && gone_->id == id) || was_undeployed(id)) {
    answer(head, REPLY_REFUSED, "device " + options_.device + " has already ended this deployment");
    return;
  }
  if (deployment_ && deployment_->id == id && !deployment_->over && deployment_->undeployers.empty()) {
    if (deployment_->ready_since)
      answer(head, REPLY_OK, "",
             model::json_text(Deployment::ports_of(deployment_->of_device(), deployment_->found)));
    else
      deployment_->preparers.push_back(head);
    return;
  }
  if (deployment_) {
    Problem problem{"", occupied(), deployment_->over ? "undeploy it first" : ""};
    answer(head, REPLY_REFUSED, in_words({problem}), model::json_text(problems_json({problem})));
    return;
  }
  auto deployment = std::make_unique<Deployment>();
  deployment->id = id;
  deployment->transaction.id = id;
  deployment->file = head.value().to_string();
  deployment->text = command.data;
  deployment->require_real_time = options_.require_real_time || head.property() == wire::kRequireRealTime;
  deployment->preparers.push_back(head);
  begin(std::move(deployment));
}

void Agent::begin(std::unique_ptr<Deployment> deployment) {
  resuming_ = false;
  last_refusal_.clear();
  drop_gone();
  deployment_ = std::move(deployment);
  auto found = find_device(deployment_->text, deployment_->file, options_.device);
  if (!found) {
    abandon(found.problems());
    return;
  }
  if (auto secured = check_security(found->cell); !secured) {
    deployment_->cell = std::move(found->cell);
    abandon(secured.problems());
    return;
  }
  deployment_->cell = std::move(found->cell);
  deployment_->device = found->device;
  if (deployment_->transaction.devices.empty())
    deployment_->transaction.devices = model::device_names(deployment_->cell);
  log("preparing cell " + deployment_->cell.name);
  auto inspection = factories_.inspect({.text = deployment_->text,
                                        .file = deployment_->file,
                                        .device = options_.device,
                                        .as_written = options_.temporary,
                                        .swapped = deployment_->swapped});
  if (!inspection) {
    abandon(inspection.problems());
    return;
  }
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

// Ends a deployment that could not be started, and answers the waiting commands with the problems.
void Agent::abandon(const Problems& problems) {
  if (update_ && update_->in_transit()) {
    update_->taken_down(problems);
    return;
  }
  if (!deployment_->undeployers.empty() || deployment_->ended_elsewhere) {
    log("cell " + deployment_->cell.name + " is undeployed");
    last_refusal_.clear();
  } else if (deployment_->stage() == Stage::undone && deployment_->transaction.t0) {
    last_refusal_ = "cell " + deployment_->cell.name + " was not started: " + deployment_->undone;
  } else if (deployment_->preparers.empty() && !deployment_->over) {
    log("cell " + deployment_->cell.name + " could not be restored: " + in_words(problems));
    last_refusal_ = to_text(problems[0]);
    // The next start of the node restores the cell, unless it is undeployed before.
    deployment_->over = !ending_ && !deployment_->cell.name.empty();
    if (deployment_->over) return;
  }
  for (const Command& preparer : deployment_->preparers)
    answer(preparer, REPLY_FAILED, in_words({problems[0]}), model::json_text(problems_json(problems)));
  for (const Command& undeployer : deployment_->undeployers) answer(undeployer, REPLY_OK, "");
  clear();
}

void Agent::step_supervised() {
  if (!deployment_ || !deployment_->supervised || deployment_->over) return;
  Deployment& d = *deployment_;
  d.supervised->step();
  switch (d.supervised->phase()) {
    case Phase::preparing:
    case Phase::running:
      break;
    case Phase::stopping:
      note_failure();
      break;
    case Phase::ready:
      if (!d.ready_since && d.stage() == Stage::prepared && !check_others()) break;
      if (!d.ready_since) {
        // Count from the end of the preparation, not from now: the client sent no message while this node
        // searched for the other devices.
        d.ready_since = d.prepared_at.value_or(options_.now());
        for (const Command& preparer : d.preparers)
          answer(preparer, REPLY_OK, "", model::json_text(Deployment::ports_of(d.of_device(), d.found)));
        d.preparers.clear();
        if (d.has_begun()) {
          go();
          if (!update_) keep_for_restart();
        }
        if (update_ && update_->in_transit()) update_->brought_up();
      } else if (d.has_begun()) {
        go();
      } else {
        step_connectors();
      }
      break;
    case Phase::ended:
      note_failure();
      finish();
      break;
  }
}

// Returns true if this node has found the nodes of all other devices of the cell, with which it decides
// whether the cell starts, and has compared its clock with theirs. Undoes the deployment if this takes too
// long, or if the clocks differ too much: the devices begin at the same time of their wall clocks.
bool Agent::check_others() {
  Deployment& d = *deployment_;
  if (!d.prepared_at) d.prepared_at = options_.now();
  for (const model::Device& device : d.cell.devices) {
    const auto nodes = others_.of_device(device.name);
    const bool found = std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.alive; });
    if (device.name == options_.device) continue;
    const auto clock = ahead(device.name);
    if (found && clock && !differ(*clock)) continue;
    if (found && clock)
      undo(difference_text(options_.device, device.name, *clock));
    else if (options_.now() - *d.prepared_at > kOthersFound)
      undo((found ? "it has had no answer from device " : "it has not found device ") + device.name +
           "; check the network between the two devices");
    return false;
  }
  return true;
}

// Returns true if this command refers to the present deployment. Otherwise rejects the command.
bool Agent::is_prepared(const Command& command) {
  const std::string id = command.deployment().to_string();
  if (deployment_ && (id.empty() || deployment_->id == id)) return true;
  const std::string device = "device " + options_.device;
  if (gone_ && gone_->id == id)
    answer(command, REPLY_REFUSED, device + " has undone this deployment: " + gone_->undone);
  else
    answer(command, REPLY_REFUSED,
           device + " has not prepared " + (deployment_ ? "this deployment" : "a deployment"));
  return false;
}

void Agent::connect(const wire::WholeCommand& whole) {
  const Command& command = whole.head;
  if (!is_prepared(command)) return;
  Deployment& d = *deployment_;
  if (!d.ready_since || d.supervised->phase() != Phase::ready || d.stage() != Stage::prepared) {
    answer(command, REPLY_REFUSED, occupied());
    return;
  }
  d.safe = whole.data;
  if (!d.connecting_since) d.connecting_since = options_.now();
  d.connectors.push_back(command);
}

// Answers the commands that wait for the connections to other devices. Undoes the deployment if a connection
// takes too long.
void Agent::step_connectors() {
  Deployment& d = *deployment_;
  if (d.connectors.empty()) return;
  const std::string unmatched = d.supervised->unmatched();
  if (unmatched.empty()) {
    d.transaction.complete = true;
    keep_for_restart();
    for (const Command& connector : std::exchange(d.connectors, {})) answer(connector, REPLY_OK, "");
  } else if (options_.now() - *d.connecting_since > kConnected) {
    undo("the connection " + unmatched + " could not be made; check the network between the devices");
  }
}

void Agent::go() {
  Deployment& d = *deployment_;
  d.supervised->give_safe(model::parse_safe(d.safe));
  d.supervised->go(*d.t0);
  std::string components;
  for (const model::Module& module : d.of_device().modules) {
    const std::string component = d.component_of(module.name);
    if (!component.empty()) components += (components.empty() ? ": " : ", ") + component;
  }
  note({.kind = model::FaultKind::deployed,
        .cause = "cell " + d.cell.name + " runs, from " + d.file + components});
}

// Undoes the deployment without a command. The other devices hear this, and undo it too, unless one of them
// is final.
void Agent::undo(const std::string& why) {
  Deployment& d = *deployment_;
  d.transaction.state = transaction::fail(d.transaction.state, why);
  log("the deployment of cell " + d.cell.name + " is undone: " + why);
  take_back(why);
}

// Undoes the deployment if the device has failed before T0. A device that fails after T0 fails as a running
// device does.
void Agent::note_failure() {
  Deployment& d = *deployment_;
  const bool starts = d.stage() == Stage::armed || d.stage() == Stage::running;
  if (!starts || time_of(d.transaction) >= d.transaction.state.t0_ns || !d.undone.empty() ||
      !d.undeployers.empty())
    return;
  const Problems& failures = d.supervised->failures();
  d.undone = !failures.empty() ? in_words({failures[0]}) : "its node is shutting down";
  d.transaction.state = transaction::fail(d.transaction.state, d.undone);
}

// Ends the deployment without a command.
void Agent::take_back(const std::string& why) {
  Deployment& d = *deployment_;
  d.undone = why;
  if (update_) update_->drop("its deployment is undone");
  if (!d.supervised)
    abandon({fail(why)});
  else if (d.over)
    finish();
  else
    stop();
}

// Ends the deployment if another device of the cell has undeployed it. This device may have missed the
// command, because it was lost then, or because the operator was lost before sending the command to all
// devices.
void Agent::check_undeployed() {
  const Deployment* const d = deployment_ ? deployment_.get() : gone_.get();
  if (d == nullptr || !d->undeployers.empty() || ending_) return;
  for (const model::Device& device : d->cell.devices) {
    if (device.name == options_.device) continue;
    for (const auto& [status, alive] : others_.of_device(device.name)) {
      if (!alive || status.undeployed() != d->id) continue;
      if (!deployment_) return remember_undeployed(d->id);
      if (d->ended_elsewhere) return;
      deployment_->ended_elsewhere = true;
      remember_undeployed(deployment_->id);
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
  if (!options_.store) return;
  keep_for_restart();
  if (const auto kept = options_.store->keep_undeployed(undeployed_); !kept)
    log("warning: if this node restarts, it does not pass on that a deployment was undeployed: " +
        in_words(kept.problems()));
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
  if (deployment_ && !id.empty() && deployment_->id != id) {
    answer(command, REPLY_REFUSED,
           "device " + options_.device + " has another deployment, of cell " + deployment_->cell.name);
    return;
  }
  if (update_) update_->drop("it was undeployed");
  if (!deployment_) {
    resuming_ = false;
    if (!id.empty()) remember_undeployed(id);
    drop_gone();
    keep_for_restart();  // removes also a saved deployment that was not restored
    last_refusal_.clear();
    answer(command, REPLY_OK, "device " + options_.device + " has no deployment",
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
  const bool started = d.ready_since.has_value();
  std::vector<Command> unfinished = std::move(d.preparers);
  unfinished.insert(unfinished.end(), d.connectors.begin(), d.connectors.end());
  const std::vector<Command> undeployers = std::move(d.undeployers);
  const bool in_transit = update_ && update_->in_transit();
  const Problems reasons =
      failures.empty() ? Problems{fail(d.undone.empty() ? "it was undeployed" : d.undone)} : failures;
  ended_at_ = options_.now();
  nlohmann::ordered_json texts = nlohmann::ordered_json::array();
  for (const Problem& problem : failures) texts.push_back(to_text(problem));
  // An operator has undeployed the cell, and another device received the command earlier. This is no failure.
  const bool passed_on = d.ended_elsewhere;
  if (!d.undone.empty() && !passed_on && (failures.empty() || d.undone != in_words({failures[0]})))
    texts.push_back(to_text(Problem{"device " + options_.device, d.undone, ""}));
  last_id_ = d.id;
  last_data_ = model::json_text({{"report", d.supervised->report()}, {"failures", texts}});
  if (!started && unfinished.empty() && undeployers.empty() && !failures.empty())
    last_refusal_ = to_text(failures[0]);

  filter_.flush();
  const bool forward = d.replaced && failures.empty() && undeployers.empty() && !passed_on && !ending_;
  // Until an update is complete, the cell runs on; then the update records itself.
  // A module that was given up before has not ended the cell, if an operator or the node has stopped it.
  if (started && !d.over && !forward && !(in_transit && failures.empty())) {
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
  if (undeployers.empty() && started && d.undone.empty()) {
    d.over = true;
    if (update_) update_->device_ended(failures, d.supervised->stops_cell());
    return;
  }
  if (!undeployers.empty() || passed_on) log("cell " + d.cell.name + " is undeployed");
  if (d.stage() == Stage::undone && d.transaction.t0 && undeployers.empty())
    last_refusal_ = "cell " + d.cell.name + " was not started: " + d.undone;
  clear();
  publish_status();  // before the answers, so that a client with an answer sees that the device is free
  for (const Command& command : unfinished)
    answer(command, REPLY_FAILED, in_words({reasons[0]}), model::json_text(problems_json(reasons)));
  for (const Command& undeployer : undeployers) answer(undeployer, REPLY_OK, "", last_data_);
}

void Agent::clear() {
  if (!deployment_->describers.empty()) described(fail("the deployment ended before it was described"));
  if (deployment_->swap) answer(*deployment_->swap, REPLY_FAILED, "the device is stopping");
  if (deployment_->supervised && !deployment_->modules.empty() && !has_given_way_)
    publisher_.withdraw(deployment_->modules, deployment_->supervised->measures());
  if (deployment_->stage() == Stage::undone) {
    auto undone = deployment_->afresh();
    undone->undone = deployment_->undone;
    set_gone(std::move(undone));
  }
  deployment_.reset();
}

}  // namespace takt::agent
