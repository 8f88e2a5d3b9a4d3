// Deploys a cell, or updates a running deployment and changes only what differs (takt deploy --update).
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
#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>
#include "limits.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;
using model::Change;
using Phase = Supervised::Phase;

void Agent::reply_problems(const Command& command, ReplyCode code, const Problems& problems,
                           const std::string& value) {
  answer(command, code, problems.empty() ? "" : in_words({problems[0]}),
         problems.empty() ? "" : model::json_text(problems_json(problems)), {}, value);
}

void Agent::Deployment::take_over(const Deployment& next) {
  file = next.file;
  text = next.text;
  safe = next.safe;
  transaction = next.transaction;
}

// Returns a device that may still need this device's decision about the last transaction, or an empty string.
// While there is such a device, this one takes part in no other transaction, because it publishes only one
// stage.
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

// Returns why the device cannot take part in the deployment or update that the command begins.
std::optional<Problem> Agent::obstacle(const Command& command) const {
  const std::string id = command.deployment().to_string();
  const bool is_new = command.property() == command.deployment();
  const auto why = [this](const std::string& what, const std::string& fix = {}) {
    return Problem{"device " + options_.device, what, fix};
  };
  const auto of_cell = [](const Deployment& d) { return " cell " + d.cell.name; };
  if (id.empty() || command.property().size() == 0) return why("the command is damaged");
  if (ending_) return why("its node is shutting down");
  if (update_ && update_->is_deployment())
    return why("it is already preparing" + of_cell(update_->after()), "wait for it, or undeploy it");
  if (update_) return why("another operator is updating it", "try again when that update is over");
  if (is_new && ((gone_ && gone_->id == id) || was_undeployed(id)))
    return why("it has already ended this deployment");
  const Deployment* const d = deployment_.get();
  if (is_new && d != nullptr) {
    if (d->over) return why("it still holds" + of_cell(*d) + ", which has ended", "undeploy it first");
    if (!d->supervised || d->supervised->phase() == Phase::preparing)
      return why("it is already preparing" + of_cell(*d), "wait for it, or undeploy it");
    if (d->supervised->phase() == Phase::stopping)
      return why("it is shutting down" + of_cell(*d), "try again later");
    return why("it already runs" + of_cell(*d), "undeploy it first");
  }
  if (d != nullptr && d->swap) return why("one of its modules is being swapped", "try again later");
  if (d != nullptr && d->id != id) return why("it has another deployment, of" + of_cell(*d));
  const bool runs =
      d != nullptr && !d->over && d->is_final() && d->supervised && d->supervised->phase() == Phase::running;
  if (d != nullptr && !runs)
    return why(std::string{"it is not running: its state is "} + takt::to_text(status().state()),
               "undeploy the cell and deploy it again");
  const std::string other = is_new ? "" : undecided_on();
  if (!other.empty())
    return why("device " + other + " has not decided about the last deployment or update yet",
               "try again when both devices are in contact");
  return std::nullopt;
}

void Agent::prepare(const wire::WholeCommand& command) {
  const Command& head = command.head;
  if (const auto problem = obstacle(head)) return reply_problems(head, REPLY_REFUSED, {*problem});
  auto update = std::make_shared<Update>(*this, command);
  if (auto compared = update->compare(); !compared)
    return reply_problems(head, REPLY_REFUSED, compared.problems());
  resuming_ = false;
  last_refusal_.clear();
  drop_gone();
  update_ = std::move(update);
  update_->inspect();
}

Agent::Update* Agent::update_of(const Command& command) {
  const std::string id = command.property().to_string();
  if (update_ && update_->id() == id) return update_.get();
  if (was_undeployed(command.deployment().to_string())) {
    reply_problems(command, REPLY_REFUSED, {{"device " + options_.device, "it was undeployed", ""}},
                   wire::kUndeployed);
    return nullptr;
  }
  const bool is_undone = gone_ && gone_->transaction.id == id && !gone_->undone.empty();
  reply_problems(command, REPLY_REFUSED,
                 {is_undone ? why_undone()
                            : Problem{"device " + options_.device,
                                      "it has not prepared this deployment or update, or has undone it",
                                      "run takt deploy again"}});
  return nullptr;
}

Problem Agent::why_undone() const {
  return {"device " + options_.device, "it has undone this: " + gone_->undone, "run takt deploy again"};
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

void Agent::Update::step() {
  if (inspection_) {
    const auto result = inspection_->result();
    if (!result) return;
    inspection_.reset();
    inspected(*result);
    return;
  }
  if (stage_ == Stage::changing && is_after_) connect();
  if (stage_ == Stage::changed) confirm();
  if (const auto failed = failed_change()) return undo({*failed});
  if (stage_ != Stage::held && !is_complete()) return;
  while (!is_final() && agent_.decide(after_->transaction, renewed_)) {
    const transaction::State& state = transaction().state;
    if (state.stage == transaction::Stage::undone) {
      const auto others = agent_.heard(transaction());
      const bool elsewhere = std::any_of(others.begin(), others.end(), [](const auto& other) {
        return other.second && other.second->stage == transaction::Stage::undone;
      });
      after_->undone_elsewhere = elsewhere;
      if (is_after_) agent_.deployment_->undone_elsewhere = elsewhere;
      return undo({fail(state.why)});
    }
    after_->take_t0();
    if (is_final()) agent_.keep_for_restart();
    if (state.stage == transaction::Stage::running) begin();
  }
  if (!is_final() || !agent_.is_saved()) return;
  begin();
  kept();
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

std::string Agent::Update::progress() const {
  if (is_final()) return "";
  const std::string what = is_deployment() ? "the deployment" : "the update";
  if (is_undoing()) return what + " is being undone";
  const bool waits = stage_ == Stage::held || is_complete();
  const auto silent = std::chrono::duration_cast<std::chrono::seconds>(agent_.options_.now() - renewed_);
  if (waits && transaction().state.stage == transaction::Stage::prepared && silent > kSoonSilent)
    return what + " is undone in " +
           takt::to_text(std::max(Nanoseconds{0}, transaction::kOperatorSilent - silent)) +
           ", unless takt deploy is heard again";
  return is_deployment() ? "" : what + " is in progress";
}

void Agent::Update::change(const wire::WholeCommand& command) {
  const Change change = difference_.change;
  const bool far = span(agent_.options_.wall_ns(), command.head.time_ns()) > transaction::kFurthestStart;
  if (stage_ != Stage::held || (change == Change::added && (far || command.head.time_ns() < 0))) {
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
  renew();
  stage_ = Stage::changing;
  carried_out_ = true;
  if (!is_deployment()) {
    for (const std::string& line : model::in_words(difference_)) agent_.log("is being updated: " + line);
  }
  switch (change) {
    case Change::none:
      return changed();
    case Change::in_place:
      return change_next();
    case Change::anew:
    case Change::removed:
      return agent_.stop();
    case Change::added:
      after_->t0_ns = command.head.time_ns();
      if (after_->t0_ns != 0) after_->t0 = agent_.options_.instant_of_wall(after_->t0_ns);
      after_->require_real_time =
          agent_.options_.require_real_time || command.head.value() == wire::kRequireRealTime;
      is_after_ = true;
      return agent_.begin_again(*after_, {.id = after_->id});
  }
}

void Agent::Update::changed() {
  if (undoer_) return undo({fail(kCancelled)});
  stage_ = Stage::changed;
  after_->transaction.complete = true;
  agent_.keep_for_restart();
  confirm();
}

void Agent::Update::confirm() {
  if (!asker_ || !agent_.is_saved()) return;
  agent_.answer(*std::exchange(asker_, std::nullopt), REPLY_OK, "");
}

void Agent::Update::note_undone(const Problems& problems) {
  stage_ = Stage::undoing;
  reasons_ = problems;
  after_->undone = in_words({problems[0]});
  after_->transaction.state = transaction::fail(transaction().state, after_->undone);
}

void Agent::Update::undo(const Problems& problems) {
  if (is_final()) return;
  const bool nothing = stage_ == Stage::checking || stage_ == Stage::held;
  note_undone(problems);
  if (nothing || difference_.change == Change::none) return undone();
  if (is_deployment())
    agent_.deployment_->undone = after_->undone;
  else
    agent_.log("undoing the update: " + in_words(reasons_));
  if (difference_.change == Change::in_place) return undo_last();
  if (!is_after_) return bring_back();
  if (!agent_.deployment_->over) return agent_.stop();
  agent_.clear();
  bring_back();
}

void Agent::Update::undone() {
  const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
  const std::string cell = "cell " + after_->cell.name;
  if (carried_out_ || !undoer_)
    agent_.log((is_deployment() ? "the deployment of " + cell + " is undone: " : "is not updated: ") +
               in_words(reasons_));
  // The end of a cell that has begun is recorded already, with the same reason.
  if (carried_out_ && !(is_deployment() && began_)) {
    agent_.note({.kind = model::FaultKind::failed_command,
                 .cause = (is_deployment() ? "deployment of " : "update to ") + after_->file +
                          " was undone: " + in_words(reasons_) +
                          (left_.empty() ? "" : "; " + in_words(left_))});
  }
  if (is_deployment() && transaction().t0)
    agent_.last_refusal_ = cell + " was not started: " + after_->undone;
  const bool elsewhere = after_->undone_elsewhere;
  agent_.set_gone(std::move(after_));
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
    agent_.reply_problems(*undoer_, REPLY_OK,
                          elsewhere || reasons_[0].what == kCancelled ? Problems{} : reasons_, value);
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
      return undo({fail(kCancelled)});
    case Stage::changing:
      if (in_transit() && is_after_) return undo({fail(kCancelled)});
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
  if (is_undoing()) return refused(reasons_);
  if (!is_complete())
    return refused({fail("device " + agent_.options_.device + " has not made its changes yet")});
  if (auto accepted = agent_.receive_t0(after_->transaction, command.time_ns()); !accepted)
    return refused(accepted.problems());
  agent_.answer(command, REPLY_OK, "");
}

void Agent::put_back(const Command& command) {
  const std::string id = command.property().to_string();
  const Transaction* const last = newest_transaction();
  if (last != nullptr && last->id == id && last->state.stage == transaction::Stage::final)
    return reply_problems(command, REPLY_REFUSED, {fail("all devices have kept the update")}, wire::kKept);
  if (update_ && update_->id() == id) return update_->cancel(command);
  // There is nothing to undo any more.
  const bool has_undone = gone_ && gone_->transaction.id == id && !gone_->undone_elsewhere;
  reply_problems(command, REPLY_OK, has_undone ? Problems{why_undone()} : Problems{}, wire::kAsBefore);
}

void Agent::Update::kept() {
  const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
  Deployment& after = *after_;
  const std::string file = after.file;
  const bool after_is_deployment = is_deployment();
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
  std::string all;
  for (const std::string& line : model::in_words(difference_)) all += ": " + line;
  if (!all.empty() && !after_is_deployment) {
    agent_.log("is updated");
    agent_.note({.kind = model::FaultKind::command, .cause = "update to " + file + " was carried out" + all});
  }
}

bool Agent::Update::is_before_t0() const {
  const std::int64_t t0_ns = transaction().state.t0_ns;
  return stage_ == Stage::changed && (t0_ns == 0 || agent_.time_of(transaction()) < t0_ns);
}

std::optional<Problem> Agent::Update::failed_change() const {
  if (difference_.change != Change::in_place || !is_before_t0()) return std::nullopt;
  for (const model::ModuleChange& one : difference_.in_place) {
    const LifecycleStatus& module = agent_.deployment_->modules.at(agent_.deployment_->index_of(one.module));
    // An input may be stale because the update has restarted another device.
    const bool fails = module.state() == STATE_RECOVER && module.error() != ERROR_STALE;
    if (one.property == kLogLevelProperty || !(fails || is_given_up(module))) continue;
    const std::string where = "module " + agent_.options_.device + "." + one.module;
    std::string why = module.text().to_string();
    // The text of a module that was given up also says how to start it again, but the update does this.
    for (const Problem& problem : agent_.deployment_->supervised->failures()) {
      if (problem.where == where) why = problem.what;
    }
    return Problem{where, one.words + ": it went to " + takt::to_text(module.state()) + ": " + why, ""};
  }
  return std::nullopt;
}

void Agent::Update::device_fails(const Problems& failures) {
  if (!is_after_ || !is_before_t0()) return;
  note_undone(failures.empty() ? Problems{fail("device " + agent_.options_.device + " has ended")}
                               : failures);
}

void Agent::Update::device_ended(const Problems& failures, bool stops_cell) {
  if (is_deployment() || is_final()) return;
  const std::string why = "the device has ended" + (failures.empty() ? "" : ": " + in_words({failures[0]}));
  if (is_after_ && stage_ == Stage::changed && !stops_cell)
    undo({fail(why)});
  else
    drop(why);
}

void Agent::Update::drop(const std::string& why, bool is_undeployed) {
  const auto self = std::exchange(agent_.update_, nullptr);  // keeps the update alive in this function
  const Problems problems{{"device " + agent_.options_.device, why, ""}};
  if (after_->transaction.state.stage != transaction::Stage::undone) note_undone(problems);
  if (is_after_ && before_)
    agent_.deployment_->take_over(*before_);  // a restarted node begins the old one
  else if (is_after_)
    agent_.deployment_->transaction = after_->transaction;
  agent_.set_gone(std::move(after_));
  for (const auto& waits : {asker_, undoer_}) {
    if (waits) agent_.reply_problems(*waits, REPLY_FAILED, problems, is_undeployed ? wire::kUndeployed : "");
  }
}

}  // namespace takt::agent
