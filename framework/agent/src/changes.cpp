// Carries out an update on a device, or undoes it. Either the agent changes the running modules one after the
// other, or it ends the present deployment and starts the new one.
#include <algorithm>
#include <utility>

#include <takt/core/log_level.hpp>

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
  began_ = true;
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
      module, value, set_by_swap(change.module, stage_ == Stage::undoing),
      [this, alive = weak_from_this(), done, index, value](const Outcome& outcome) {
        if (alive.expired()) return;
        if (outcome.code == REPLY_OK && agent_.deployment_) note_file(index, value);
        done(outcome);
      });
}

bool Agent::Update::is_set_by_swap(const model::ModuleChange& change) const {
  const auto& all = difference_.in_place;
  return !change.property.empty() && change.property != kLogLevelProperty &&
         std::any_of(all.begin(), all.end(), [&change](const model::ModuleChange& other) {
           return other.module == change.module && other.property.empty();
         });
}

std::map<std::string, std::string> Agent::Update::set_by_swap(const std::string& module, bool before) const {
  std::map<std::string, std::string> values;
  for (std::size_t i = 0; i < replaced_.size(); ++i) {
    const model::ModuleChange& one = difference_.in_place[i];
    if (one.module == module && is_set_by_swap(one)) values[one.property] = before ? replaced_[i] : one.value;
  }
  return values;
}

// Records the file of a module's component, and its build.
void Agent::Update::note_file(std::size_t index, const std::string& file) {
  Inspected& found = agent_.deployment_->found;
  const Inspected& after = after_->found;
  found.paths.at(index) = file;
  if (index >= found.builds.size() || index >= after.builds.size()) return;
  found.builds[index] = found.paths.at(index) == after.paths.at(index) ? after.builds[index] : builds_[index];
}

// The properties of a module come before its file. So if the module is swapped, their old values are known by
// then, and the new instance begins with the new values. The old instance keeps the old ones.
void Agent::Update::change_next() {
  if (undoer_) return undo({fail(kCancelled)});
  if (replaced_.size() == difference_.in_place.size()) return changed();
  const model::ModuleChange& next = difference_.in_place[replaced_.size()];
  const std::size_t index = agent_.deployment_->index_of(next.module);
  const auto failed = [this, &next](const Outcome& outcome) {
    undo({{"module " + agent_.options_.device + "." + next.module, next.words + ": " + outcome.text, ""}});
  };
  const auto go_on = [this](const std::string& before) {
    replaced_.push_back(before);
    change_next();
  };
  const auto apply_next = [this, failed, go_on, &next](const std::string& value, const std::string& before) {
    apply_change(next, value, [failed, go_on, before](const Outcome& outcome) {
      outcome.code == REPLY_OK ? go_on(before) : failed(outcome);
    });
  };
  if (next.property.empty())
    return apply_next(after_->found.paths.at(index), agent_.deployment_->found.paths.at(index));
  agent_.deployment_->supervised->get(
      static_cast<std::uint32_t>(index), next.property,
      [this, alive = weak_from_this(), failed, go_on, apply_next, &next](const Outcome& outcome) {
        if (alive.expired()) return;
        if (outcome.code != REPLY_OK) return failed(outcome);
        if (is_set_by_swap(next)) return go_on(outcome.value);
        apply_next(next.value, outcome.value);
      });
}

void Agent::Update::undo_last() {
  if (replaced_.empty()) return undone();
  const model::ModuleChange& last = difference_.in_place[replaced_.size() - 1];
  const std::string value = replaced_.back();
  const bool stays = stays_changed(last, value);
  if (stays || is_set_by_swap(last)) {
    replaced_.pop_back();
    return undo_last();
  }
  apply_change(last, value, [this, &last](const Outcome& outcome) {
    if (outcome.code != REPLY_OK) {
      agent_.log("is restarted to undo the update, because " + last.module +
                 " cannot be changed while it runs: " + outcome.text);
      return restart_undone();
    }
    replaced_.pop_back();
    undo_last();
  });
}

// Restarts the device as it was before the update. A module that has failed, or whose host has ended, accepts
// no change.
void Agent::Update::restart_undone() {
  for (; !replaced_.empty(); replaced_.pop_back()) {
    const model::ModuleChange& last = difference_.in_place[replaced_.size() - 1];
    if (last.property.empty() && !stays_changed(last, replaced_.back()))
      note_file(agent_.deployment_->index_of(last.module), replaced_.back());
  }
  difference_.change = Change::anew;
  agent_.stop();
}

// Returns true if the change is that of a file which cannot be undone, and notes this.
bool Agent::Update::stays_changed(const model::ModuleChange& change, const std::string& before) {
  if (!change.property.empty() ||
      before != after_->found.paths.at(agent_.deployment_->index_of(change.module)))
    return false;
  left_.push_back(
      {"module " + agent_.options_.device + "." + change.module,
       "its change could not be undone, because the new component has overwritten the previous one",
       "restore the previous file and run takt deploy --update again"});
  return true;
}

void Agent::Update::taken_down(const Problems& problems) {
  if (!is_after_ && !before_) {
    before_ = agent_.deployment_->afresh();
    agent_.clear();
    if (stage_ == Stage::undoing) {
      bring_back();
    } else if (undoer_) {
      note_undone({fail(kCancelled)});
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
