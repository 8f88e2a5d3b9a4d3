// Updates a running deployment to a new descriptor and changes only what differs (takt deploy --update).
//
// All devices of the cell take the same steps. The client commands the next step when all devices have
// completed the previous step: it lets them check the update, then make their changes, and then sends them
// T0. The devices decide by the rules of the room `transaction` whether they keep or undo the changes.
#include "update.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/agent/problems_json.hpp>
#include <takt/core/log_level.hpp>
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

/// Returns true if the component declares the property that the change sets. Only declared properties can be
/// set while a module runs; a module reads other properties only in initialize().
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
/// Returns true if both lists of ports can use the same links. Compares all properties on which the links
/// depend.
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

void Agent::Deployment::take_over(const Deployment& next) {
  file = next.file;
  text = next.text;
  safe = next.safe;
  transaction = next.transaction;
}

// Returns a device that may still need this device's stage in its last transaction: if this device took part
// in another one, both could decide differently about the last one. Empty if there is none.
std::string Agent::undecided_on() const {
  const Transaction* const last = newest_transaction();
  if (last == nullptr) return "";
  const bool is_undone = last->state.stage == transaction::Stage::undone && last->complete;
  for (const auto& [name, what] : heard(*last)) {
    const auto nodes = others_.of_device(name);
    const bool alive = std::any_of(nodes.begin(), nodes.end(), [](const auto& node) { return node.alive; });
    if (what ? what->stage != last->state.stage : is_undone && !alive) return name;
  }
  return "";
}

void Agent::update(const wire::WholeCommand& command) {
  const Command& head = command.head;
  const std::string device = "device " + options_.device;
  const auto refused = [&](Problem problem) { reply_problems(head, REPLY_REFUSED, {std::move(problem)}); };
  if (ending_) return refused(fail("the node of " + device + " is shutting down"));
  if (update_)
    return refused({device, "another operator is updating it", "try again when that update is over"});
  if (deployment_ && deployment_->swap)
    return refused({device, "one of its modules is being swapped", "try again later"});
  if (deployment_ && deployment_->id != head.deployment().to_string())
    return refused({device, "it has another deployment, of cell " + deployment_->cell.name, ""});
  const bool runs = deployment_ && !deployment_->over && deployment_->is_final() && deployment_->supervised &&
                    deployment_->supervised->phase() == Phase::running;
  if (deployment_ && !runs)
    return refused({device, std::string{"it is not running: its state is "} + takt::to_text(status().state()),
                    "undeploy the cell and deploy it again"});

  if (const std::string other = undecided_on(); !other.empty())
    return refused({device, "device " + other + " has not decided about the last deployment or update yet",
                    "try again when both devices are in contact"});

  auto update = std::make_shared<Update>(*this, command);
  if (auto compared = update->compare(); !compared)
    return reply_problems(head, REPLY_REFUSED, compared.problems());
  drop_gone();
  update_ = std::move(update);
  update_->inspect();
}

Agent::Update* Agent::update_of(const Command& command) {
  if (update_ && update_->id() == command.property().to_string()) return update_.get();
  reply_problems(command, REPLY_REFUSED,
                 {{"device " + options_.device, "no such update is in progress; it may have been undone",
                   "start the update again"}});
  return nullptr;
}

Agent::Update::Update(Agent& agent, const wire::WholeCommand& command)
    : agent_(agent),
      id_(command.head.property().to_string()),
      after_(agent.deployment_ ? agent.deployment_->afresh() : std::make_unique<Deployment>()),
      asker_(command.head),
      renewed_(agent.options_.now()) {
  after_->id = command.head.deployment().to_string();
  after_->transaction = {.id = id_};
  after_->file = command.head.value().to_string();
  after_->text = command.data;
}

// Compares the running descriptor with the new one, without looking at the components.
Result<void> Agent::Update::compare() {
  Deployment& after = *after_;
  auto cell = descriptor::parse(after.text, after.file);
  if (!cell) return cell.problems();
  after.cell = std::move(*cell);
  if (auto secured = agent_.check_security(after.cell); !secured) return secured;
  const auto& devices = after.cell.devices;
  const auto mine = std::find_if(devices.begin(), devices.end(), [this](const model::Device& one) {
    return one.name == agent_.options_.device;
  });
  if (mine != devices.end()) {
    after.device = static_cast<std::size_t>(mine - devices.begin());
    if (auto plan = schedule::plan(after.cell, *mine); !plan) return plan.problems();
  }
  if (!agent_.deployment_) {
    if (mine == devices.end())
      return fail("cell " + after.cell.name + " has no device " + agent_.options_.device);
    difference_ = {.device = agent_.options_.device, .change = Change::added};
    return {};
  }
  auto all = model::differences(agent_.deployment_->cell, after.cell);
  if (!all) return all.problems();
  for (model::DeviceDifference& one : *all) {
    if (one.device == agent_.options_.device) difference_ = std::move(one);
  }
  after.transaction.devices =
      model::device_names(agent_.deployment_->cell);  // until the client sends all devices
  if (difference_.change == Change::removed) after.text.clear();
  if (mine != devices.end()) after.inherit(*agent_.deployment_);
  return {};
}

void Agent::Update::inspect() {
  Deployment& after = *after_;
  if (difference_.change == Change::removed) return inspected(Inspected{});
  // If a change sets a property, the components must be described, because only their descriptions state
  // which properties can be set.
  const auto& in_place = difference_.in_place;
  const bool sets =
      std::any_of(in_place.begin(), in_place.end(), [](const auto& one) { return !one.property.empty(); });
  auto inspection = agent_.factories_.inspect({.text = after.text,
                                               .file = after.file,
                                               .device = agent_.options_.device,
                                               .as_written = agent_.options_.temporary,
                                               .describe = sets,
                                               .swapped = after.swapped});
  if (inspection)
    inspection_ = std::move(*inspection);
  else
    inspected(inspection.problems());
}

void Agent::Update::step() {
  if (inspection_) {
    const auto result = inspection_->result();
    if (!result) return;
    inspection_.reset();
    inspected(*result);
    return;
  }
  if (stage_ != Stage::held && stage_ != Stage::changed) return;
  while (agent_.decide(after_->transaction, renewed_)) {
    const transaction::State& state = transaction().state;
    if (state.stage == transaction::Stage::undone) return undo({fail(state.why)});
    if (state.stage == transaction::Stage::final) return kept();
  }
}

void Agent::Update::inspected(const Result<Inspected>& result) {
  const auto refused = [this](const Problems& problems) {
    note_undone(problems);
    const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
    agent_.set_gone(std::move(after_));
    agent_.reply_problems(*asker_, REPLY_REFUSED, problems);
  };
  if (!result) return refused(result.problems());
  Change& change = difference_.change;
  if (agent_.deployment_) builds_ = agent_.deployment_->found.builds;
  if (change == Change::none || change == Change::in_place) add_rebuilt(*result);
  const Inspected& found = change == Change::none ? agent_.deployment_->found : *result;
  if (change == Change::in_place) judge_in_place(*result);
  if (change == Change::in_place) {
    if (const auto may = may_change_in_place(); !may) return refused(may.problems());
  }
  after_->found = found;
  json data = change == Change::removed ? json{{"modules", json::array()}}
                                        : Deployment::ports_of(after_->of_device(), found);
  data["change"] = model::to_text(change);
  data["words"] = model::in_words(difference_);
  if (agent_.deployment_) {
    data["t0_ns"] = agent_.deployment_->t0_ns;
    data["require_real_time"] = agent_.deployment_->require_real_time;
  }
  stage_ = Stage::held;
  renewed_ = agent_.options_.now();
  agent_.answer(*std::exchange(asker_, std::nullopt), REPLY_OK, "", model::json_text(data));
}

// Adds to the changes each module whose file has the same name as before, but different contents.
void Agent::Update::add_rebuilt(const Inspected& found) {
  for (const model::Module& module : after_->of_device().modules) {
    const auto& changes = difference_.in_place;
    const bool has_new_file = std::any_of(changes.begin(), changes.end(), [&module](const auto& one) {
      return one.module == module.name && one.property.empty();
    });
    const std::size_t index = agent_.deployment_->index_of(module.name);
    if (has_new_file || index >= builds_.size() || index >= found.builds.size()) continue;
    const model::Build& before = builds_[index];
    const model::Build& after = found.builds[index];
    if (before.hash.empty() || after.hash.empty() || before.hash == after.hash) continue;
    difference_.add_file(module, found.paths.at(index),
                         "file " + module.filename + ": " + to_text(before) + " -> " + to_text(after));
  }
}

// Checks, with the information from the components, whether the changes are possible while the modules run.
// If they are not, marks the device for a restart.
void Agent::Update::judge_in_place(const Inspected& found) {
  model::DeviceDifference& difference = difference_;
  for (const model::ModuleChange& one : difference.in_place) {
    const std::size_t index = agent_.deployment_->index_of(one.module);
    std::string why = "module " + one.module;
    if (one.property.empty() &&
        !same_ports(ports_at(agent_.deployment_->found, index), ports_at(found, index)))
      why += " has different ports in its new file";
    else if (!one.property.empty() && one.property != kLogLevelProperty && !declares(found.description, one))
      why += " reads property " + one.property + " only in initialize()";
    else
      continue;
    difference.make_anew(why);
    return;
  }
}

Result<void> Agent::Update::may_change_in_place() const {
  Problems problems;
  const Deployment& d = *agent_.deployment_;
  for (const model::ModuleChange& one : difference_.in_place) {
    const std::size_t index = d.index_of(one.module);
    const LifecycleState state = d.modules.at(index).state();
    if (one.property.empty()) {
      if (const auto may = d.supervised->may_swap(static_cast<std::uint32_t>(index)); !may)
        problems.insert(problems.end(), may.problems().begin(), may.problems().end());
    } else if (one.property != kLogLevelProperty && (state == STATE_IDLE || state == STATE_DESTRUCT)) {
      problems.push_back({"module " + agent_.options_.device + "." + one.module,
                          std::string{"it is in "} + takt::to_text(state) +
                              "; its properties can be set once it is in INITIALIZE",
                          "reset and start the module, or deploy the cell again"});
    }
  }
  if (!problems.empty()) return problems;
  return {};
}

void Agent::Update::change(const wire::WholeCommand& command) {
  const Change change = difference_.change;
  const bool far = span(agent_.options_.wall_ns(), command.head.time_ns()) > transaction::kFurthestStart;
  if (stage_ != Stage::held || (change == Change::added && (far || command.head.time_ns() <= 0))) {
    agent_.reply_problems(
        command.head, REPLY_REFUSED,
        {stage_ != Stage::held
             ? fail("the update is not yet checked, or is already carried out")
             : fail("the start time of the cell is not valid on device " + agent_.options_.device,
                    "synchronise the clocks of the devices")});
    return;
  }
  const json data = model::parse_json(command.data);
  try {
    after_->transaction.devices = data.at("devices").get<std::vector<std::string>>();
    after_->safe = model::json_text(data.at("safe"));
  } catch (const json::exception&) {
    return agent_.reply_problems(command.head, REPLY_REFUSED, {fail("the command is damaged")});
  }
  asker_ = command.head;
  stage_ = Stage::changing;
  for (const std::string& line : model::in_words(difference_)) agent_.log("is being updated: " + line);
  switch (change) {
    case Change::none:
      return changed();
    case Change::in_place:
      return change_next();
    case Change::anew:
    case Change::removed:
      return agent_.deployment_->supervised->stop();
    case Change::added:
      after_->t0_ns = command.head.time_ns();
      after_->t0 = agent_.options_.instant_of_wall(after_->t0_ns);
      after_->require_real_time =
          agent_.options_.require_real_time || command.head.value() == wire::kRequireRealTime;
      is_after_ = true;
      return agent_.begin_again(*after_, {.id = after_->id, .state = {.stage = transaction::Stage::final}});
  }
}

void Agent::Update::changed() {
  if (undoer_) return undo({fail("the update was cancelled")});
  stage_ = Stage::changed;
  renewed_ = agent_.options_.now();
  after_->transaction.complete = true;
  agent_.keep_for_restart();
  agent_.answer(*std::exchange(asker_, std::nullopt), REPLY_OK, "");
}

void Agent::Update::note_undone(const Problems& problems) {
  stage_ = Stage::undoing;
  reasons_ = problems;
  after_->undone = in_words({problems[0]});
  after_->transaction.state = transaction::fail(transaction().state, after_->undone);
}

void Agent::Update::undo(const Problems& problems) {
  const bool nothing = stage_ == Stage::checking || stage_ == Stage::held;
  note_undone(problems);
  if (nothing || difference_.change == Change::none) return undone();
  agent_.log("undoing the update: " + in_words(reasons_));
  if (difference_.change == Change::in_place) return undo_last();
  if (!is_after_) return bring_back();
  if (!agent_.deployment_->over) return agent_.deployment_->supervised->stop();
  agent_.clear();
  bring_back();
}

void Agent::Update::undone() {
  const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
  agent_.set_gone(std::move(after_));
  agent_.log("is not updated: " + in_words(reasons_));
  if (!left_.empty()) {
    agent_.log("could not undo the update: " + in_words(left_));
    if (!agent_.deployment_) agent_.last_refusal_ = to_text(left_[0]);
  }
  agent_.publish_status();
  const std::string value = left_.empty() ? wire::kAsBefore : "";
  if (asker_) {
    Problems all = reasons_;
    all.insert(all.end(), left_.begin(), left_.end());
    agent_.reply_problems(*asker_, REPLY_FAILED, all, value);
  }
  if (undoer_ && left_.empty())
    agent_.answer(*undoer_, REPLY_OK, "", {}, {}, value);
  else if (undoer_)
    agent_.reply_problems(*undoer_, REPLY_FAILED, left_, value);
}

void Agent::Update::cancel(const Command& command) {
  if (undoer_)
    return agent_.reply_problems(command, REPLY_REFUSED, {fail("the update is already being undone")});
  undoer_ = command;
  switch (stage_) {
    case Stage::checking:
    case Stage::held:
    case Stage::changed:
      return undo({fail("the update was cancelled")});
    case Stage::changing:
      if (in_transit() && is_after_) return undo({fail("the update was cancelled")});
      return;  // change_next(), changed() or taken_down() undoes the update after the present step
    case Stage::undoing:
      return;
  }
}

// Accepts T0 from the operator.
void Agent::Update::run(const Command& command) {
  const auto refused = [&](const Problems& problems) {
    agent_.reply_problems(command, REPLY_REFUSED, problems);
  };
  if (stage_ != Stage::changed) return refused({fail("the update has not been carried out")});
  if (auto accepted = agent_.receive_t0(after_->transaction, command.time_ns()); !accepted)
    return refused(accepted.problems());
  agent_.answer(command, REPLY_OK, "");
}

void Agent::put_back(const Command& command) {
  const std::string id = command.property().to_string();
  if (update_ && update_->id() == id) return update_->cancel(command);
  const Transaction* const last = newest_transaction();
  if (last != nullptr && last->id == id && last->state.stage == transaction::Stage::final)
    return reply_problems(command, REPLY_REFUSED, {fail("all devices have kept the update")}, wire::kKept);
  answer(command, REPLY_OK, "", {}, {}, wire::kAsBefore);  // there is nothing to undo
}

void Agent::Update::kept() {
  const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
  Deployment& after = *after_;
  const std::string file = after.file;
  if (difference_.change == Change::removed) {
    agent_.set_gone(std::move(after_));
  } else {
    Deployment& d = *agent_.deployment_;
    if (!is_after_) {
      after.inherit(d);
      d.swapped = after.swapped;
      d.set = after.set;
    }
    d.take_over(after);
    d.cell = after.cell;
    d.device = after.device;
    d.description.clear();
    if (d.describing) {
      d.describing.reset();
      agent_.described(fail("the device was updated in the meantime", "try again"));
    }
  }
  agent_.keep_for_restart();
  std::string all;
  for (const std::string& line : model::in_words(difference_)) all += ": " + line;
  if (!all.empty()) {
    agent_.log("is updated");
    agent_.note({.kind = model::FaultKind::command, .cause = "update to " + file + " was carried out" + all});
  }
}

void Agent::Update::device_ended(const Problems& failures, bool stops_cell) {
  const std::string why = "the device has ended" + (failures.empty() ? "" : ": " + in_words({failures[0]}));
  if (is_after_ && stage_ == Stage::changed && !stops_cell)
    undo({fail(why)});
  else
    drop(why);
}

void Agent::Update::drop(const std::string& why) {
  const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
  const Problems problems{{"device " + agent_.options_.device, why, ""}};
  if (after_->transaction.state.stage != transaction::Stage::undone) note_undone(problems);
  if (is_after_ && before_) agent_.deployment_->take_over(*before_);  // a restarted node begins the old one
  agent_.set_gone(std::move(after_));
  for (const auto& waits : {asker_, undoer_}) {
    if (waits) agent_.reply_problems(*waits, REPLY_FAILED, problems);
  }
}

}  // namespace takt::agent
