// Decides, by the rules of the room `transaction`, about an update in which this device takes part, and
// follows the decisions of the other devices later.
#include <algorithm>
#include <utility>

#include "limits.hpp"
#include "update.hpp"

namespace takt::agent {

using transaction::Stage;

Result<void> Agent::receive_t0(Transaction& transaction, std::int64_t t0_ns) {
  const auto accepted = transaction::receive_t0(transaction.state, t0_ns, time_of(transaction));
  if (!accepted) return accepted.problems();
  transaction.state = *accepted;
  if (!transaction.t0) transaction.t0 = options_.instant_of_wall(t0_ns);
  return {};
}

// The time of the transaction: the wall clock, but the monotonic clock continues it once T0 is known, so it
// does not matter if the wall clock is set then.
std::int64_t Agent::time_of(const Transaction& transaction) const {
  if (!transaction.t0) return options_.wall_ns();
  return transaction.state.t0_ns + (options_.now() - *transaction.t0).count();
}

// Returns what was heard last from each other device about the transaction.
transaction::Others Agent::heard(const Transaction& transaction) const {
  transaction::Others others;
  for (const std::string& device : transaction.devices) {
    if (device == options_.device) continue;
    std::optional<transaction::Heard>& what = others[device];
    for (const auto& [status, alive] : others_.of_device(device)) {
      if (!alive || status.transaction() != transaction.id) continue;
      const auto stage = static_cast<Stage>(status.stage());
      // Before this device is complete, no other device can be armed.
      if (!transaction.complete && stage != Stage::undone) continue;
      if (!what || stage > what->stage) what = transaction::Heard{stage, status.t0_ns()};
    }
  }
  return others;
}

bool Agent::decide(Transaction& transaction, std::optional<Instant> operator_heard) {
  const std::int64_t now = time_of(transaction);
  transaction.state.operator_heard_ns =
      operator_heard ? now - (options_.now() - *operator_heard).count() : now;
  transaction::State after = transaction::next(transaction.state, heard(transaction), now);
  if (after.stage == transaction.state.stage) return false;
  transaction.state = std::move(after);
  if (!transaction.t0 && transaction.state.t0_ns != 0)
    transaction.t0 = options_.instant_of_wall(transaction.state.t0_ns);
  return true;
}

const Agent::Transaction* Agent::newest_transaction() const {
  if (update_) return &update_->transaction();
  if (gone_) return &gone_->transaction;
  return deployment_ ? &deployment_->transaction : nullptr;
}

// Goes forward again if another device is final. Once no device can go the other way any more, the agent
// forgets what it would need for that.
void Agent::step_gone() {
  if (!gone_ || update_ || ending_ || resuming_) return;
  Transaction& t = gone_->transaction;
  decide(t, std::nullopt);
  if (t.state.stage == Stage::final && (deployment_ || gone_->has_device())) return go_forward();
  if (!t.complete || !transaction::settled(t.state, heard(t))) return;
  t.complete = false;
  keep_for_restart();
}

// Begins the final deployment `gone_`. Stops the present deployment before, if there is one. A device that
// has failed stays as it is; it only gets the new descriptor.
void Agent::go_forward() {
  if (deployment_ && deployment_->supervised && !deployment_->over) {
    if (std::exchange(deployment_->replaced, true)) return;
    log("cell " + deployment_->cell.name +
        " is updated, because every device of the cell had made its changes");
    return stop();
  }
  if (!gone_->has_device()) {
    if (deployment_) clear();
    return keep_for_restart();
  }
  const std::unique_ptr<Deployment> next = std::move(gone_);
  if (deployment_ && deployment_->supervised) {
    deployment_->take_over(*next);
    return keep_for_restart();
  }
  if (deployment_) clear();
  if (next->update().empty())
    log("cell " + next->cell.name + " begins again, because every device of the cell had begun");
  deployment_ = next->afresh();
  deployment_->take_t0();
  keep_for_restart();
  begin(std::move(deployment_));
}

void Agent::set_gone(std::unique_ptr<Deployment> deployment) {
  if (!was_undeployed(deployment->id)) gone_ = std::move(deployment);
}

// Forgets a deployment or update that this device has undone, because the operator has replaced it. The other
// devices of the cell end such a deployment.
void Agent::drop_gone() {
  const auto dropped = std::exchange(gone_, nullptr);
  if (dropped && dropped->update().empty()) remember_undeployed(dropped->id);
}

}  // namespace takt::agent
