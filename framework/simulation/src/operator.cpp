#include "operator.hpp"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>
#include <takt/model/safe.hpp>
#include <takt/wire/words.hpp>
#include "network.hpp"
#include "node.hpp"

namespace takt::simulation {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Nanoseconds kLooksEvery = milliseconds{5};
/// A node from which nothing arrives for this time is lost.
constexpr Nanoseconds kLostAfter = milliseconds{300};
// The following times are those of the room client.
constexpr Nanoseconds kBack = milliseconds{700};
constexpr Nanoseconds kLongest = std::chrono::minutes{2};
constexpr Nanoseconds kBegun = seconds{10};
constexpr Nanoseconds kLead = milliseconds{400};
constexpr Nanoseconds kConfirmed = milliseconds{100};
constexpr Nanoseconds kDecided = seconds{6};
constexpr Nanoseconds kKeptAliveEvery = seconds{4};

}  // namespace

Operator::Operator(const World& world) : world_(world), seen_(world.cell().devices.size()) {
  world_.kernel.at(world_.kernel.now(), [this] { step(); });
}

void Operator::begin_at(Instant t0) {
  given_t0_ = t0;
  begin(Action::deploy);
}

void Operator::go_down(Nanoseconds lasts) {
  pause(lasts);
  end("the operator went down");
}

void Operator::end(const std::string& why) {
  if (stage_ != Stage::nothing) {
    why_ = why;
    finish(Outcome::unknown);
  }
  for (const Action action : std::exchange(waiting_, {})) {
    action_ = action;
    transaction_.clear();
    why_ = why;
    finish(Outcome::unchanged);
  }
}

void Operator::pause(Nanoseconds lasts) { away_until_ = std::max(away_until_, world_.kernel.now() + lasts); }

void Operator::receive(const wire::WholeReply& reply) {
  const auto found = open_.find(reply.head.id().to_string());
  if (found == open_.end() || found->second.code) return;  // the first reply counts
  found->second.code = reply.head.code();
  found->second.text = reply.head.text().to_string();
  const auto data = model::parse_json(reply.data);
  if (stage_ == Stage::preparing && action_ == Action::update && data.is_object() && data.contains("t0_ns"))
    deployed_t0_ns_ = data["t0_ns"].get<std::int64_t>();
}

void Operator::hear(const DeviceStatus& status) {
  for (std::uint32_t i = 0; i < devices(); ++i) {
    if (status.device() == world_.cell().devices[i].name)
      seen_[i][status.node().to_string()] = {status, world_.kernel.now()};
  }
}

bool Operator::is_alive(const Seen& seen) const { return world_.kernel.now() - seen.at <= kLostAfter; }

std::vector<const Operator::Seen*> Operator::alive(std::uint32_t device) const {
  std::vector<const Seen*> found;
  for (const auto& [node, seen] : seen_[device]) {
    if (is_alive(seen)) found.push_back(&seen);
  }
  return found;
}

void Operator::note(std::uint32_t device, const std::string& why) {
  const std::string where = "device " + world_.cell().devices[device].name + ": ";
  if (why_.empty()) why_ = why.starts_with(where) ? why : where + why;
}

std::size_t Operator::in_stage(TransactionStage stage) const {
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < devices(); ++i) {
    for (const Seen* seen : alive(i))
      count += seen->status.transaction() == transaction_ && seen->status.stage() == stage ? 1 : 0;
  }
  return count;
}

void Operator::send(CommandKind kind, Nanoseconds limit) {
  kept_alive_ = world_.kernel.now();
  if (kind != COMMAND_REPORT) {
    limit_ = limit;
    open_.clear();
  }
  for (std::uint32_t i = 0; i < devices(); ++i) {
    const bool undoes = kind == COMMAND_UNDEPLOY || kind == COMMAND_PUT_BACK;
    const auto nodes = alive(i);
    if (undoes && nodes.empty()) {
      note(i, "it is lost");
      unreached_ = true;
      continue;
    }
    const std::string node = nodes.empty() ? "" : nodes[0]->status.node().to_string();
    wire::WholeCommand command;
    command.head.id("c" + std::to_string(++commands_));
    wire::set(command.head.device(), world_.cell().devices[i].name);
    wire::set(command.head.node(), node);
    command.head.kind(kind);
    wire::set(command.head.deployment(), deployment_);
    wire::set(command.head.property(), transaction_);
    wire::set(command.head.value(), version().cell.file);
    command.head.time_ns(t0_ns_);
    command.head.deadline_ns(to_ns(world_.kernel.now() + std::min(limit, kBegun)));
    if (kind == COMMAND_PREPARE) command.data = version().cell.file + ' ';  // the nodes know its content
    if (kind == COMMAND_CHANGE) {
      command.head.time_ns(action_ == Action::update ? deployed_t0_ns_ : 0);
      command.data = model::json_text({{"devices", model::device_names(version().cell)},
                                       {"safe", model::parse_json(model::safe_json(
                                                    model::safe_outputs(version().cell, version().ports)))}});
    }
    if (kind != COMMAND_REPORT) {
      Open& open = open_[command.head.id().to_string()] = {i, node, world_.kernel.now()};
      if (nodes.size() > 1) {
        open.code = REPLY_REFUSED;
        open.text = std::to_string(nodes.size()) + " nodes have this name";
        continue;
      }
    }
    // Of several nodes with this name, only the one that is named takes the command.
    for (std::uint32_t address = 0; address < world_.nodes->size(); ++address) {
      world_.network->tell(Network::kOperator, address, true, [command, &node = *(*world_.nodes)[address]] {
        node.deliver([command, &node] { node.receive(command); });
      });
    }
  }
}

Operator::Replies Operator::replies() {
  const Instant now = world_.kernel.now();
  bool bad = false;
  for (auto& [id, one] : open_) {
    if (!one.code) {
      const Instant heard = std::max(seen_[one.device][one.node].at, one.sent);
      const bool gone = now - heard > kLostAfter + kBack;
      if (!gone && now - one.sent <= limit_) return Replies::open;
    }
    if (one.code == REPLY_OK) continue;
    bad = true;
    note(one.device, one.code ? one.text : "no answer");
  }
  return bad ? Replies::bad : Replies::good;
}

void Operator::step() {
  world_.kernel.at(world_.kernel.now() + kLooksEvery, [this] { step(); });
  if (world_.kernel.now() < away_until_) return;
  if (stage_ == Stage::nothing) return next_action();
  if (stage_ == Stage::deciding) return decide();
  if (stage_ == Stage::agreeing) return agree();
  // While it waits for a slower device, the operator lets the devices know that it is there.
  if (world_.kernel.now() - kept_alive_ > kKeptAliveEvery && stage_ != Stage::undoing)
    send(COMMAND_REPORT, kBegun);
  const Replies got = replies();
  if (got == Replies::open) return;
  if (stage_ == Stage::undoing) {
    if (action_ == Action::update && run_sent_) {
      stage_ = Stage::agreeing;
      since_ = world_.kernel.now();
      return;
    }
    const bool known = got == Replies::good && !unreached_;
    if (action_ == Action::undeploy) return finish(known ? Outcome::done : Outcome::unknown);
    return finish(known || !run_sent_ ? Outcome::unchanged : Outcome::unknown);
  }
  if (got == Replies::bad) return undo("");
  if (stage_ == Stage::preparing) {
    stage_ = Stage::changing;
    return send(COMMAND_CHANGE, kLongest);
  }
  if (stage_ == Stage::changing) {
    t0_ns_ = to_ns(std::exchange(given_t0_, std::nullopt).value_or(world_.kernel.now() + kLead));
    run_sent_ = true;
    stage_ = Stage::running;
    return send(COMMAND_RUN, from_ns(t0_ns_) - world_.kernel.now() - kConfirmed);
  }
  stage_ = Stage::deciding;
}

void Operator::next_action() {
  if (waiting_.empty()) return;
  action_ = waiting_.front();
  waiting_.pop_front();
  why_.clear();
  run_sent_ = unreached_ = false;
  t0_ns_ = 0;
  bool runs = false;
  for (std::uint32_t i = 0; i < devices(); ++i) {
    for (const Seen* seen : alive(i))
      runs |= !deployment_.empty() && seen->status.deployment() == deployment_;
    if (is_alive(i) || action_ == Action::undeploy) continue;
    if (given_t0_) return waiting_.push_front(action_);  // the nodes have not been found yet
    note(i, "it is not found");
    return finish(Outcome::unchanged);
  }
  if (action_ != Action::deploy && !runs) {
    why_ = "no device runs the cell";
    return finish(Outcome::unchanged);
  }
  if (action_ == Action::undeploy) return undo("");
  transaction_ = (action_ == Action::update ? "update " : "deployment ") + std::to_string(++actions_);
  if (action_ == Action::deploy) deployment_ = transaction_;
  stage_ = Stage::preparing;
  send(COMMAND_PREPARE, kLongest);
}

// Waits until each device is final, or until one of them has undone the deployment or update.
void Operator::decide() {
  const std::int64_t now = to_ns(world_.kernel.now());
  if (in_stage(STAGE_FINAL) == devices()) return finish(Outcome::done);
  bool failed = now - t0_ns_ > kDecided.count();
  for (std::uint32_t i = 0; i < devices(); ++i) {
    for (const Seen* seen : alive(i)) {
      const DeviceStatus& status = seen->status;
      const bool takes_part = status.transaction() == transaction_ && status.t0_ns() == t0_ns_ &&
                              status.stage() != STAGE_UNDONE && status.undeployed() != deployment_;
      if (takes_part || now <= t0_ns_) continue;
      note(i, "it has not kept it");
      failed = true;
    }
  }
  if (failed) undo("the devices have not decided in time");
}

// Waits until the devices agree whether they keep the update.
void Operator::agree() {
  const std::size_t final = in_stage(STAGE_FINAL);
  const std::size_t undone = in_stage(STAGE_UNDONE);
  if (final < devices() && undone < devices() && world_.kernel.now() - since_ < kDecided) return;
  finish(final > 0 ? Outcome::done : undone == devices() ? Outcome::unchanged : Outcome::unknown);
}

void Operator::undo(std::string why) {
  if (why_.empty()) why_ = std::move(why);
  stage_ = Stage::undoing;
  send(action_ == Action::update ? COMMAND_PUT_BACK : COMMAND_UNDEPLOY, kLongest);
}

void Operator::finish(Outcome outcome) {
  stage_ = Stage::nothing;
  open_.clear();
  if (outcome == Outcome::done) why_.clear();  // it was done in spite of this
  reports_.push_back({.action = action_, .outcome = outcome, .transaction = transaction_, .why = why_});
  const std::string text = to_text(reports_.back());
  world_.listener.on_event({.at = world_.kernel.now(), .what = What::operated, .text = text});
}

}  // namespace takt::simulation
