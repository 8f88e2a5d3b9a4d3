// The agent's commands prepare, run and undeploy, and the deployment saved on disk.
#include "update.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include <takt/agent/problems_json.hpp>
#include <takt/core/span.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/model/json.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/wire/words.hpp>
#include "limits.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;
using Phase = Supervised::Phase;

namespace {

// Finds the device in a descriptor's text. Also plans the device's schedule, so that no later step can fail
// because of it.
struct Found {
  model::Cell cell;
  std::size_t device;
};
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
  again->t0_wall_ns = t0_wall_ns;
  again->t0 = t0;
  again->safe = safe;
  return again;
}

// Returns why the device cannot accept another deployment now.
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
  if (!name_clash_.empty()) {
    answer(head, REPLY_REFUSED, name_clash_,
           model::json_text(problems_json({{"device " + options_.device, name_clash_, "end one of them"}})));
    return;
  }
  if (ending_) {
    answer(head, REPLY_REFUSED, "the node of device " + options_.device + " is shutting down");
    return;
  }
  if (update_) {
    answer(head, REPLY_REFUSED, "device " + options_.device + " is being updated; try again later");
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
  deployment->file = head.value().to_string();
  deployment->text = command.data;
  deployment->require_real_time = options_.require_real_time || head.property() == wire::kRequireRealTime;
  deployment->preparers.push_back(head);
  begin(std::move(deployment));
}

void Agent::begin(std::unique_ptr<Deployment> deployment) {
  last_refusal_.clear();
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
  log("preparing cell " + deployment_->cell.name);
  auto inspection = factories_.inspect({.text = deployment_->text,
                                        .file = deployment_->file,
                                        .device = options_.device,
                                        .as_written = options_.temporary});
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
  publisher_.publish(status);
}

// Ends a deployment that could not be brought up, and answers with the problems.
void Agent::abandon(const Problems& problems) {
  if (update_ && update_->in_transit()) {
    update_->taken_down(problems);
    return;
  }
  if (deployment_->preparers.empty()) {
    log("cell " + deployment_->cell.name + " could not be restored: " + in_words(problems));
    last_refusal_ = to_text(problems[0]);
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
    case Phase::stopping:
      break;
    case Phase::ready:
      if (!d.ready_since) {
        d.ready_since = options_.now();
        for (const Command& preparer : d.preparers)
          answer(preparer, REPLY_OK, "", model::json_text(Deployment::ports_of(d.of_device(), d.found)));
        d.preparers.clear();
        if (d.t0_wall_ns) {
          go(*d.t0_wall_ns);
          if (!update_) keep_for_restart();
        }
        if (update_ && update_->in_transit()) update_->brought_up();
      } else if (options_.now() - *d.ready_since > kRunAwaited) {
        d.undone = "no run command arrived within " + takt::to_text(kRunAwaited);
        log("the deployment of cell " + d.cell.name + " is undone: " + d.undone);
        d.supervised->stop();
      }
      break;
    case Phase::ended:
      finish();
      break;
  }
}

void Agent::run(const wire::WholeCommand& whole) {
  const Command& command = whole.head;
  const std::string id = command.deployment().to_string();
  if (!deployment_ || (!id.empty() && deployment_->id != id)) {
    answer(command, REPLY_REFUSED,
           "device " + options_.device + " has not prepared " +
               (deployment_ ? "this deployment" : "a deployment"));
    return;
  }
  if (deployment_->t0_wall_ns == command.time_ns()) {  // a repeated command
    answer(command, REPLY_OK, "");
    return;
  }
  if (!deployment_->supervised || deployment_->supervised->phase() != Phase::ready) {
    answer(command, REPLY_REFUSED, occupied());
    return;
  }
  const Nanoseconds ahead = span(options_.wall_ns(), command.time_ns());
  if (ahead <= Nanoseconds{0} || ahead > kFurthestStart) {
    answer(command, REPLY_REFUSED,
           ahead <= Nanoseconds{0} ? "the start time passed " + takt::to_text(-ahead) + " ago on device " +
                                         options_.device + "; synchronise the clocks of the devices"
                                   : "the start time is " + takt::to_text(ahead) + " ahead on device " +
                                         options_.device + "; synchronise the clocks of the devices");
    return;
  }
  deployment_->safe = whole.data;
  go(command.time_ns());
  answer(command, REPLY_OK, "");
  keep_for_restart();  // after the answer, because the disk may take longer than the client waits
}

void Agent::go(std::int64_t t0_wall_ns) {
  Deployment& d = *deployment_;
  d.t0_wall_ns = t0_wall_ns;
  if (!d.t0) d.t0 = options_.instant_of_wall(t0_wall_ns);
  d.supervised->give_safe(model::parse_safe(d.safe));
  d.supervised->go(*d.t0);
  note({.kind = model::FaultKind::deployed, .cause = "cell " + d.cell.name + " runs, from " + d.file});
}

void Agent::keep_for_restart() {
  if (!options_.store) return;
  Deployment& d = *deployment_;
  const auto kept = options_.store->keep({.id = d.id,
                                          .file = d.file,
                                          .text = d.text,
                                          .require_real_time = d.require_real_time,
                                          .t0_ns = *d.t0_wall_ns,
                                          .boot = options_.boot,
                                          .t0_monotonic_ns = to_ns(*d.t0),
                                          .safe = d.safe});
  const bool again = std::exchange(d.unsaved, !kept);
  if (kept && again) log("cell " + d.cell.name + " is saved for --resume again");
  if (kept || again) return;
  const std::string what =
      "cell " + d.cell.name + " could not be saved for --resume: " + in_words(kept.problems());
  log("warning: " + what);
  note({.kind = model::FaultKind::error, .cause = what});
}

// Tries again to write the files that could not be written, because there may be space on the disk again.
void Agent::watch_disk() {
  const Instant now = options_.now();
  if (now - disk_tried_at_ < kDiskTriedEvery) return;
  disk_tried_at_ = now;
  if (options_.record->reopen())
    log("the fault record is written to its file again: " + options_.record->file());
  if (deployment_ && deployment_->unsaved && !update_) keep_for_restart();
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
    forget_kept();
    last_refusal_.clear();
    answer(command, REPLY_OK, "device " + options_.device + " has no deployment",
           !id.empty() && id == last_id_ ? last_data_ : "");
    return;
  }
  deployment_->undeployers.push_back(command);
  if (!deployment_->supervised) {
    abandon({fail("it was undeployed")});
  } else if (deployment_->over) {
    finish();
  } else {
    deployment_->supervised->stop();
  }
}

// Called when the deployment has ended, by a failure or on command.
void Agent::finish() {
  Deployment& d = *deployment_;
  const Problems failures = d.supervised->failures();
  const bool started = d.ready_since.has_value();
  const std::vector<Command> preparers = std::move(d.preparers);
  const std::vector<Command> undeployers = std::move(d.undeployers);
  const bool in_transit = update_ && update_->in_transit();
  ended_at_ = options_.now();
  nlohmann::ordered_json texts = nlohmann::ordered_json::array();
  for (const Problem& problem : failures) texts.push_back(to_text(problem));
  last_id_ = d.id;
  last_data_ = model::json_text({{"report", d.supervised->report()}, {"failures", texts}});
  if (!started && preparers.empty() && undeployers.empty() && !failures.empty())
    last_refusal_ = to_text(failures[0]);

  filter_.flush();
  if (started) {
    note({.kind = model::FaultKind::undeployed,
          .cause = "cell " + d.cell.name + " has ended" +
                   (!failures.empty()      ? ": " + in_words({failures[0]})
                    : !undeployers.empty() ? ": it was undeployed"
                    : !d.undone.empty()    ? ": " + d.undone
                    : in_transit           ? ": it is being updated"
                    : ending_              ? ": its node is shutting down"
                                           : "")});
  }
  devices_seen_.clear();
  if (in_transit) {
    update_->taken_down(failures);
    return;
  }
  if (undeployers.empty() && started && d.undone.empty()) {
    // An update that has replaced the deployment can still be undone.
    if (update_ && !update_->has_replaced())
      update_->drop("the device has ended" + (failures.empty() ? "" : ": " + in_words({failures[0]})));
    d.over = true;
    return;
  }
  if (!undeployers.empty()) {
    forget_kept();
    log("cell " + d.cell.name + " is undeployed");
  }
  clear();
  publish_status();  // before the answer, so that its receiver sees that the device is free
  const Problems reasons = failures.empty() ? Problems{fail("it was undeployed")} : failures;
  for (const Command& preparer : preparers)
    answer(preparer, REPLY_FAILED, in_words({reasons[0]}), model::json_text(problems_json(reasons)));
  for (const Command& undeployer : undeployers) answer(undeployer, REPLY_OK, "", last_data_);
}

void Agent::forget_kept() {
  if (!options_.store) return;
  if (const auto forgotten = options_.store->forget(); !forgotten)
    log("warning: " + in_words(forgotten.problems()));
}

void Agent::clear() {
  if (!deployment_->describers.empty()) described(fail("the deployment ended before it was described"));
  if (deployment_->swap) answer(*deployment_->swap, REPLY_FAILED, "the device is shutting down");
  if (deployment_->supervised && !deployment_->modules.empty())
    publisher_.withdraw(deployment_->modules, deployment_->supervised->measures());
  deployment_.reset();
}

void Agent::resume() {
  if (!options_.store) return;
  const auto kept = options_.store->kept();
  if (!kept) {
    log("nothing is restored: " + in_words(kept.problems()));
    last_refusal_ = to_text(kept.problems()[0]);
    return;
  }
  if (!*kept) return;
  // The wall clock may have been set, but the monotonic clock is valid until the machine is booted again.
  std::optional<Instant> t0;
  if (!options_.boot.empty() && (*kept)->boot == options_.boot) t0 = from_ns((*kept)->t0_monotonic_ns);
  // Without this limit, the device would wait silently for T0, perhaps for years if a clock is wrong.
  const Nanoseconds ahead =
      t0 ? span(to_ns(options_.now()), to_ns(*t0)) : span(options_.wall_ns(), (*kept)->t0_ns);
  if (ahead > kFurthestStart) {
    last_refusal_ = "the start time of the saved deployment is " + takt::to_text(ahead) +
                    " ahead; set the clock of device " + options_.device + ", or deploy the cell again";
    log("nothing is restored: " + last_refusal_);
    return;
  }
  auto deployment = std::make_unique<Deployment>();
  deployment->id = (*kept)->id;
  deployment->file = (*kept)->file;
  deployment->text = (*kept)->text;
  deployment->require_real_time = (*kept)->require_real_time || options_.require_real_time;
  deployment->t0_wall_ns = (*kept)->t0_ns;
  deployment->t0 = t0;
  deployment->safe = (*kept)->safe;
  begin(std::move(deployment));
}

void Agent::report_kept() const {
  if (!options_.store) return;
  const auto kept = options_.store->kept();
  if (!kept || !*kept) return;
  const auto found = find_device((*kept)->text, (*kept)->file, options_.device);
  log((found ? "cell " + found->cell.name : "a cell") +
      " was running when this node ended and is not restored; to restore it, start the node with --resume");
}

}  // namespace takt::agent
