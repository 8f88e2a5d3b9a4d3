// Carries out an update on a device, or undoes it. Either the agent changes the running modules one after the
// other, or it ends the present deployment and starts the new one.
#include <utility>

#include "clocks.hpp"
#include "limits.hpp"
#include "update.hpp"

namespace takt::agent {

using model::Change;
using Phase = Supervised::Phase;

// While an update is in progress, the device runs as part of the transaction before.
void Agent::begin_again(const Deployment& description, const Transaction& transaction) {
  last_refusal_.clear();
  deployment_ = description.afresh();
  deployment_->transaction = transaction;
  log("preparing cell " + deployment_->cell.name);
  bring_up();
}

// Waits until this node has found the nodes of all other devices, with which it decides whether the devices
// begin, has compared its clock with theirs, and is connected to them. Undoes the update if this takes too
// long, or if the clocks differ too much: the devices begin at the same time of their wall clocks.
void Agent::Update::connect() {
  const Supervised& supervised = *agent_.deployment_->supervised;
  if (supervised.phase() != Phase::ready) return;
  const Instant now = agent_.options_.now();
  if (!ready_since_) ready_since_ = now;
  bool others_ready = true;
  for (const std::string& device : after_->transaction.devices) {
    if (device == agent_.options_.device) continue;
    bool found = false;
    for (const auto& [status, alive] : agent_.others_.of_device(device)) {
      if (!alive) continue;
      found = true;
      others_ready &= status.state() != DEVICE_PREPARING && status.state() != DEVICE_STOPPING;
    }
    const auto clock = agent_.ahead(device);
    if (found && clock && differ(*clock))
      return undo({fail(difference_text(agent_.options_.device, device, *clock))});
    if (found && clock) continue;
    if (now - *ready_since_ <= kOthersFound) return;
    return undo({fail((found ? "it has had no answer from device " : "it has not found device ") + device +
                      "; check the network between the two devices")});
  }
  const std::string unmatched = supervised.unmatched();
  if (unmatched.empty()) return changed();
  if (!connecting_since_ || !others_ready) connecting_since_ = now;
  if (now - *connecting_since_ > kConnected)
    undo({fail("the connection " + unmatched + " could not be made; check the network between the devices")});
}

// Lets the modules that the update has started begin at T0.
void Agent::Update::begin() {
  if (!is_after_ || agent_.deployment_->began) return;
  agent_.deployment_->t0_ns = after_->t0_ns;
  agent_.deployment_->t0 = after_->t0;
  agent_.go();
}

// Sets the property of a module to `value`, or swaps the module to the file `value`.
void Agent::Update::apply_change(const model::ModuleChange& change, const std::string& value,
                                 const std::function<void(const Outcome&)>& done) {
  const std::size_t index = agent_.deployment_->index_of(change.module);
  const auto module = static_cast<std::uint32_t>(index);
  const auto done_if_alive = [alive = weak_from_this(), done](const Outcome& outcome) {
    if (!alive.expired()) done(outcome);
  };
  if (!change.property.empty()) {
    agent_.deployment_->supervised->set(module, change.property, value, done_if_alive);
    return;
  }
  agent_.deployment_->supervised->swap(
      module, value, [this, alive = weak_from_this(), done, index, value](const Outcome& outcome) {
        if (alive.expired()) return;
        if (outcome.code == REPLY_OK && agent_.deployment_) {
          agent_.deployment_->found.paths.at(index) = value;
          note_build(index);
        }
        done(outcome);
      });
}

// Records the build of a module's component after a swap.
void Agent::Update::note_build(std::size_t index) {
  Inspected& found = agent_.deployment_->found;
  const Inspected& after = after_->found;
  if (index >= found.builds.size() || index >= after.builds.size()) return;
  found.builds[index] = found.paths.at(index) == after.paths.at(index) ? after.builds[index] : builds_[index];
}

void Agent::Update::change_next() {
  if (undoer_) return undo({fail("the update was cancelled")});
  if (replaced_.size() == difference_.in_place.size()) return changed();
  const model::ModuleChange& next = difference_.in_place[replaced_.size()];
  const std::size_t index = agent_.deployment_->index_of(next.module);
  const auto failed = [this, &next](const Outcome& outcome) {
    undo({{"module " + agent_.options_.device + "." + next.module, next.words + ": " + outcome.text, ""}});
  };
  const auto apply_next = [this, failed, &next](const std::string& value, const std::string& before) {
    apply_change(next, value, [this, failed, before](const Outcome& outcome) {
      if (outcome.code != REPLY_OK) return failed(outcome);
      replaced_.push_back(before);
      change_next();
    });
  };
  if (next.property.empty())
    return apply_next(after_->found.paths.at(index), agent_.deployment_->found.paths.at(index));
  agent_.deployment_->supervised->get(
      static_cast<std::uint32_t>(index), next.property,
      [alive = weak_from_this(), failed, apply_next, &next](const Outcome& outcome) {
        if (alive.expired()) return;
        if (outcome.code != REPLY_OK) return failed(outcome);
        apply_next(next.value, outcome.value);
      });
}

void Agent::Update::undo_last() {
  if (replaced_.empty()) return undone();
  const model::ModuleChange& last = difference_.in_place[replaced_.size() - 1];
  const std::string value = replaced_.back();
  replaced_.pop_back();
  const std::string module = "module " + agent_.options_.device + "." + last.module;
  if (last.property.empty() && value == after_->found.paths.at(agent_.deployment_->index_of(last.module))) {
    left_.push_back(
        {module, "its change could not be undone, because the new component has overwritten the previous one",
         "restore the previous file and run takt deploy --update again"});
    return undo_last();
  }
  apply_change(last, value, [this, &last, module](const Outcome& outcome) {
    if (outcome.code != REPLY_OK)
      left_.push_back({module, last.words + " could not be undone: " + outcome.text,
                       "undeploy the cell and deploy it again"});
    undo_last();
  });
}

void Agent::Update::taken_down(const Problems& problems) {
  if (stage_ == Stage::changing && !is_after_) {
    before_ = agent_.deployment_->afresh();
    agent_.clear();
    if (undoer_) {
      note_undone({fail("the update was cancelled")});
      bring_back();
    } else if (difference_.change == Change::removed) {
      changed();
    } else {
      is_after_ = true;
      agent_.begin_again(*after_, before_->transaction);
    }
    return;
  }
  agent_.clear();
  if (stage_ == Stage::changing) {
    note_undone(problems.empty() ? Problems{fail("device " + agent_.options_.device + " has ended")}
                                 : problems);
    bring_back();
  } else if (is_after_) {
    bring_back();
  } else {
    for (const Problem& problem : problems)
      left_.push_back({problem.where, "it no longer runs: " + problem.what, problem.fix});
    if (left_.empty()) left_.push_back(fail("device " + agent_.options_.device + " no longer runs"));
    undone();
  }
}

void Agent::Update::bring_back() {
  is_after_ = false;
  if (before_)
    agent_.begin_again(*before_, before_->transaction);
  else
    undone();
}

}  // namespace takt::agent
