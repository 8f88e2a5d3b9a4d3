// Updates a running deployment to a new descriptor and changes only what differs (takt deploy --update).
//
// All devices of the cell take the same steps. The client commands the next step when all devices have
// completed the one before. Until the last step this device can undo its changes, and does so by itself if it
// receives nothing from the client for a while.
#include "update.hpp"

#include <algorithm>
#include <utility>

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
using model::Change;
using Phase = Supervised::Phase;

namespace {

const model::Module* find_module(const model::Device& device, const std::string& name) {
  const auto found = std::find_if(device.modules.begin(), device.modules.end(),
                                  [&name](const model::Module& module) { return module.name == name; });
  return found == device.modules.end() ? nullptr : &*found;
}

bool same_property(const model::Module& one, const model::Module& other, const std::string& name) {
  const auto first = model::given_property(one, name);
  const auto second = model::given_property(other, name);
  return first.ok() == second.ok() && (!first || *first == *second);
}

/// Whether the component declares the property. Only declared properties can be set while a module runs;
/// others are read only in initialize().
bool declares(const std::string& description, const model::ModuleChange& change) {
  const json all = model::parse_json(description);
  if (!all.is_object()) return false;
  for (const json& module : all.value("modules", json::array())) {
    if (module.value("name", "") != change.module) continue;
    for (const json& property : module.value("properties", json::array())) {
      if (property.value("name", "") == change.property) return true;
    }
  }
  return false;
}

model::ModulePorts ports_at(const Inspected& found, std::size_t module) {
  return module < found.ports.size() ? found.ports[module] : std::nullopt;
}
/// Compares everything that the links depend on.
bool same_ports(const model::ModulePorts& before, const model::ModulePorts& after) {
  if (!before || !after) return !before && !after;
  return std::is_permutation(before->begin(), before->end(), after->begin(), after->end(),
                             [](const model::Port& one, const model::Port& other) {
                               return one.name == other.name && one.direction == other.direction &&
                                      one.object == other.object && one.role == other.role &&
                                      one.safe == other.safe &&
                                      model::difference(one.type, other.type).empty();
                             });
}

}  // namespace

void Agent::reply_problems(const Command& command, ReplyCode code, const Problems& problems,
                           const std::string& value) {
  answer(command, code, in_words({problems[0]}), model::json_text(problems_json(problems)), {}, value);
}

std::size_t Agent::Deployment::index_of(const std::string& module) const {
  return static_cast<std::size_t>(find_module(of_device(), module) - of_device().modules.data());
}

void Agent::Deployment::inherit(const Deployment& other) {
  swapped.clear();
  set.clear();
  for (const model::Module& module : of_device().modules) {
    const model::Module* const was = find_module(other.of_device(), module.name);
    if (was == nullptr) continue;
    const auto exchanged = other.swapped.find(module.name);
    if (exchanged != other.swapped.end() && was->filename == module.filename)
      swapped[module.name] = exchanged->second;
    const auto values = other.set.find(module.name);
    if (values == other.set.end()) continue;
    for (const auto& [name, value] : values->second) {
      if (same_property(*was, module, name)) set[module.name][name] = value;
    }
  }
}

void Agent::update(const wire::WholeCommand& command) {
  const Command& head = command.head;
  const std::string device = "device " + options_.device;
  const auto refused = [&](Problem problem) { reply_problems(head, REPLY_REFUSED, {std::move(problem)}); };
  if (!name_clash_.empty()) return refused({device, name_clash_, "end one of them"});
  if (ending_) return refused(fail("the node of " + device + " is shutting down"));
  if (update_)
    return refused({device, "another operator is updating it", "try again when that update is over"});
  if (deployment_ && deployment_->swap)
    return refused({device, "one of its modules is being swapped", "try again later"});
  if (deployment_ && deployment_->id != head.deployment().to_string())
    return refused({device, "it has another deployment, of cell " + deployment_->cell.name, ""});
  const bool runs = deployment_ && !deployment_->over && deployment_->supervised &&
                    deployment_->supervised->phase() == Phase::running;
  if (deployment_ && !runs)
    return refused({device, std::string{"it is not running: its state is "} + takt::to_text(status().state()),
                    "undeploy the cell and deploy it again"});

  auto update = std::make_shared<Update>();
  update->id = head.property().to_string();
  update->after = deployment_ ? deployment_->afresh() : std::make_unique<Deployment>();
  update->after->id = head.deployment().to_string();
  update->after->file = head.value().to_string();
  update->after->text = command.data;
  update->heard = options_.now();
  if (auto compared = compare(*update); !compared)
    return reply_problems(head, REPLY_REFUSED, compared.problems());
  update_ = std::move(update);
  update_->asker = head;
  Deployment& after = *update_->after;
  const Change change = update_->difference.change;
  if (change == Change::none || change == Change::removed) return update_inspected(Inspected{});
  // Only the components tell which properties can be set.
  const auto& in_place = update_->difference.in_place;
  const bool sets =
      std::any_of(in_place.begin(), in_place.end(), [](const auto& one) { return !one.property.empty(); });
  auto inspection = factories_.inspect({.text = after.text,
                                        .file = after.file,
                                        .device = options_.device,
                                        .as_written = options_.temporary,
                                        .describe = sets,
                                        .swapped = after.swapped});
  if (inspection)
    update_->inspection = std::move(*inspection);
  else
    update_inspected(inspection.problems());
}

// Compares the descriptors, without the components.
Result<void> Agent::compare(Update& update) const {
  Deployment& after = *update.after;
  auto cell = descriptor::parse(after.text, after.file);
  if (!cell) return cell.problems();
  after.cell = std::move(*cell);
  if (auto secured = check_security(after.cell); !secured) return secured;
  const auto& devices = after.cell.devices;
  const auto mine = std::find_if(devices.begin(), devices.end(),
                                 [this](const model::Device& one) { return one.name == options_.device; });
  if (mine != devices.end()) {
    after.device = static_cast<std::size_t>(mine - devices.begin());
    if (auto plan = schedule::plan(after.cell, *mine); !plan) return plan.problems();
  }
  if (!deployment_) {
    if (mine == devices.end()) return fail("cell " + after.cell.name + " has no device " + options_.device);
    update.difference = {.device = options_.device, .change = Change::added};
    return {};
  }
  auto all = model::differences(deployment_->cell, after.cell);
  if (!all) return all.problems();
  for (model::DeviceDifference& one : *all) {
    if (one.device == options_.device) update.difference = std::move(one);
  }
  if (mine != devices.end()) after.inherit(*deployment_);
  return {};
}

void Agent::check_update() {
  if (!update_) return;
  if (update_->inspection) {
    const auto result = update_->inspection->result();
    if (!result) return;
    update_->inspection.reset();
    update_inspected(*result);
    return;
  }
  const bool waits = update_->stage == Update::Stage::held || update_->stage == Update::Stage::changed;
  if (waits && options_.now() - update_->heard > kRunAwaited)
    undo({fail("no further command of the update arrived within " + takt::to_text(kRunAwaited))});
}

void Agent::update_inspected(const Result<Inspected>& result) {
  Update& u = *update_;
  const auto refused = [this](const Problems& problems) {
    const auto dropped = std::exchange(update_, nullptr);
    reply_problems(*dropped->asker, REPLY_REFUSED, problems);
  };
  if (!result) return refused(result.problems());
  Change& change = u.difference.change;
  const Inspected& found = change == Change::none ? deployment_->found : *result;
  if (change == Change::in_place) judge_in_place(*result);
  if (change == Change::in_place) {
    if (const auto may = may_change_in_place(); !may) return refused(may.problems());
  }
  u.after->found = found;
  json data = change == Change::removed ? json{{"modules", json::array()}}
                                        : Deployment::ports_of(u.after->of_device(), found);
  data["change"] = model::to_text(change);
  data["words"] = model::in_words(u.difference);
  if (deployment_) {
    data["t0_ns"] = *deployment_->t0_wall_ns;
    data["require_real_time"] = deployment_->require_real_time;
  }
  u.stage = Update::Stage::held;
  u.heard = options_.now();
  answer(*std::exchange(u.asker, std::nullopt), REPLY_OK, "", model::json_text(data));
}

// Checks with the components whether the changes are possible while the modules run. If not, the device must
// be restarted.
void Agent::judge_in_place(const Inspected& found) {
  model::DeviceDifference& difference = update_->difference;
  for (const model::ModuleChange& one : difference.in_place) {
    const std::size_t index = deployment_->index_of(one.module);
    std::string why = "module " + one.module;
    if (one.property.empty() && !same_ports(ports_at(deployment_->found, index), ports_at(found, index)))
      why += " has other ports in its new file";
    else if (!one.property.empty() && !declares(found.description, one))
      why += " reads property " + one.property + " only in initialize()";
    else
      continue;
    difference.make_anew(why);
    return;
  }
}

Result<void> Agent::may_change_in_place() const {
  Problems problems;
  const Deployment& d = *deployment_;
  for (const model::ModuleChange& one : update_->difference.in_place) {
    const std::size_t index = d.index_of(one.module);
    const LifecycleState state = d.modules.at(index).state();
    if (one.property.empty()) {
      if (const auto may = d.supervised->may_swap(static_cast<std::uint32_t>(index)); !may)
        problems.insert(problems.end(), may.problems().begin(), may.problems().end());
    } else if (state == STATE_IDLE || state == STATE_DESTRUCT) {
      problems.push_back({"module " + options_.device + "." + one.module,
                          std::string{"it is in "} + takt::to_text(state) +
                              "; its properties can be set once it is in INITIALIZE",
                          "reset and start it, or deploy the cell again"});
    }
  }
  if (!problems.empty()) return problems;
  return {};
}

bool Agent::updates(const Command& command) {
  if (update_ && update_->id == command.property().to_string()) return true;
  reply_problems(command, REPLY_REFUSED,
                 {{"device " + options_.device, "no such update is in progress; it may have been undone",
                   "start the update again"}});
  return false;
}

void Agent::change(const wire::WholeCommand& command) {
  if (!updates(command.head)) return;
  Update& u = *update_;
  const Change change = u.difference.change;
  const bool far = span(options_.wall_ns(), command.head.time_ns()) > kFurthestStart;
  if (u.stage != Update::Stage::held || (change == Change::added && (far || command.head.time_ns() <= 0))) {
    reply_problems(command.head, REPLY_REFUSED,
                   {u.stage != Update::Stage::held
                        ? fail("the update is not yet checked, or is already carried out")
                        : fail("the start time of the cell is not valid on device " + options_.device,
                               "synchronise the clocks of the devices")});
    return;
  }
  u.after->safe = command.data;
  u.asker = command.head;
  u.stage = Update::Stage::changing;
  for (const std::string& line : model::in_words(u.difference)) log("is being updated: " + line);
  switch (change) {
    case Change::none:
      return changed();
    case Change::in_place:
      return change_next();
    case Change::anew:
    case Change::removed:
      return deployment_->supervised->stop();
    case Change::added:
      u.after->t0_wall_ns = command.head.time_ns();
      u.after->require_real_time =
          options_.require_real_time || command.head.value() == wire::kRequireRealTime;
      u.is_after = true;
      return begin_again(*u.after);
  }
}

void Agent::changed() {
  Update& u = *update_;
  u.stage = Update::Stage::changed;
  u.heard = options_.now();
  if (u.undoer) return undo({fail("the update was cancelled")});
  answer(*std::exchange(u.asker, std::nullopt), REPLY_OK, "");
}

void Agent::undo(const Problems& problems) {
  Update& u = *update_;
  const bool nothing = u.stage == Update::Stage::checking || u.stage == Update::Stage::held;
  u.stage = Update::Stage::undoing;
  u.reasons = problems;
  if (nothing || u.difference.change == Change::none) return undone();
  log("undoing the update: " + in_words(u.reasons));
  if (u.difference.change == Change::in_place) return undo_last();
  if (!u.is_after) return bring_back();
  if (!deployment_->over) return deployment_->supervised->stop();
  clear();
  bring_back();
}

void Agent::undone() {
  const auto u = std::exchange(update_, nullptr);
  log("is not updated: " + in_words(u->reasons));
  if (!u->left.empty()) {
    log("could not undo the update: " + in_words(u->left));
    if (!deployment_) last_refusal_ = to_text(u->left[0]);
  }
  publish_status();
  const std::string value = u->left.empty() ? wire::kAsBefore : "";
  if (u->asker) {
    Problems all = u->reasons;
    all.insert(all.end(), u->left.begin(), u->left.end());
    reply_problems(*u->asker, REPLY_FAILED, all, value);
  }
  if (u->undoer && u->left.empty())
    answer(*u->undoer, REPLY_OK, "", {}, {}, value);
  else if (u->undoer)
    reply_problems(*u->undoer, REPLY_FAILED, u->left, value);
}

void Agent::put_back(const Command& command) {
  if (!update_ || update_->id != command.property().to_string())
    return answer(command, REPLY_OK, "", {}, {}, wire::kAsBefore);  // there is nothing to undo
  Update& u = *update_;
  if (u.undoer) return reply_problems(command, REPLY_REFUSED, {fail("the update is already being undone")});
  u.undoer = command;
  switch (u.stage) {
    case Update::Stage::checking:
    case Update::Stage::held:
    case Update::Stage::changed:
      return undo({fail("the update was cancelled")});
    case Update::Stage::changing:
      if (u.in_transit() && u.is_after) return undo({fail("the update was cancelled")});
      return;  // undo after the step that is in progress
    case Update::Stage::undoing:
      return;
  }
}

void Agent::keep(const Command& command) {
  if (!updates(command)) return;
  if (update_->stage != Update::Stage::changed || (deployment_ && deployment_->over)) {
    reply_problems(command, REPLY_REFUSED,
                   {{"device " + options_.device,
                     update_->stage != Update::Stage::changed ? "the update has not been carried out"
                                                              : "it has ended in the meantime",
                     ""}});
    return;
  }
  const auto u = std::exchange(update_, nullptr);
  Deployment& after = *u->after;
  if (u->difference.change == Change::removed) {
    forget_kept();
  } else {
    Deployment& d = *deployment_;
    if (!u->is_after) {
      after.inherit(d);
      d.swapped = after.swapped;
      d.set = after.set;
    }
    d.file = after.file;
    d.text = after.text;
    d.cell = after.cell;
    d.device = after.device;
    d.safe = after.safe;
    d.description.clear();
    if (d.describing) {
      d.describing.reset();
      described(fail("the device was updated in the meantime", "try again"));
    }
    keep_for_restart();
  }
  std::string all;
  for (const std::string& line : model::in_words(u->difference)) all += ": " + line;
  if (!all.empty()) {
    log("is updated");
    note({.kind = model::FaultKind::command, .cause = "update to " + after.file + " was carried out" + all});
  }
  answer(command, REPLY_OK, "");
}

void Agent::drop_update(const std::string& why) {
  if (!update_) return;
  const auto dropped = std::exchange(update_, nullptr);
  const Problems problems{{"device " + options_.device, why, ""}};
  for (const auto& waits : {dropped->asker, dropped->undoer}) {
    if (waits) reply_problems(*waits, REPLY_FAILED, problems);
  }
}

}  // namespace takt::agent
