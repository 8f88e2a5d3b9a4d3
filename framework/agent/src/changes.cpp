// Carries out an update on a device, or undoes it. Either the agent changes the running modules one after the
// other, or it ends the present deployment and starts the new one.
#include <utility>

#include "update.hpp"

namespace takt::agent {

using model::Change;

// While an update is in progress, the device runs as part of the transaction before, which is final.
void Agent::begin_again(const Deployment& description, const Transaction& transaction) {
  last_refusal_.clear();
  deployment_ = description.afresh();
  deployment_->transaction = transaction;
  log("preparing cell " + deployment_->cell.name);
  bring_up();
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

void Agent::Update::brought_up() {
  if (stage_ == Stage::changing)
    changed();
  else
    undone();
}

}  // namespace takt::agent
