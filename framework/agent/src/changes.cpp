// How a device carries out an update, and undoes it: either changes its running modules one after the other,
// or ends its deployment and brings another one up.
#include <utility>

#include "update.hpp"

namespace takt::agent {

using model::Change;

// Gives a module the value of a property, or its new file.
void Agent::apply_change(const model::ModuleChange& change, const std::string& value,
                         const std::function<void(const Outcome&)>& done) {
  const std::size_t index = deployment_->index_of(change.module);
  const auto module = static_cast<std::uint32_t>(index);
  const auto done_if_alive = [alive = std::weak_ptr<Update>{update_}, done](const Outcome& outcome) {
    if (!alive.expired()) done(outcome);
  };
  if (!change.property.empty()) {
    deployment_->supervised->set(module, change.property, value, done_if_alive);
    return;
  }
  deployment_->supervised->swap(module, value, [this, done_if_alive, index, value](const Outcome& outcome) {
    if (outcome.code == REPLY_OK && deployment_) deployment_->found.paths.at(index) = value;
    done_if_alive(outcome);
  });
}

void Agent::change_next() {
  Update& u = *update_;
  if (u.undoer) return undo({fail("the update was cancelled")});
  if (u.replaced.size() == u.difference.in_place.size()) return changed();
  const model::ModuleChange& next = u.difference.in_place[u.replaced.size()];
  const std::size_t index = deployment_->index_of(next.module);
  const auto failed = [this, &next](const Outcome& outcome) {
    undo({{"module " + options_.device + "." + next.module, next.words + ": " + outcome.text, ""}});
  };
  const auto apply_next = [this, failed, &next](const std::string& value, const std::string& before) {
    apply_change(next, value, [this, failed, before](const Outcome& outcome) {
      if (outcome.code != REPLY_OK) return failed(outcome);
      update_->replaced.push_back(before);
      change_next();
    });
  };
  if (next.property.empty())
    return apply_next(u.after->found.paths.at(index), deployment_->found.paths.at(index));
  deployment_->supervised->get(
      static_cast<std::uint32_t>(index), next.property,
      [alive = std::weak_ptr<Update>{update_}, failed, apply_next, &next](const Outcome& outcome) {
        if (alive.expired()) return;
        if (outcome.code != REPLY_OK) return failed(outcome);
        apply_next(next.value, outcome.value);
      });
}

void Agent::undo_last() {
  Update& u = *update_;
  if (u.replaced.empty()) return undone();
  const model::ModuleChange& last = u.difference.in_place[u.replaced.size() - 1];
  const std::string value = u.replaced.back();
  u.replaced.pop_back();
  apply_change(last, value, [this, &last](const Outcome& outcome) {
    if (outcome.code != REPLY_OK)
      update_->left.push_back({"module " + options_.device + "." + last.module,
                               last.words + " could not be undone: " + outcome.text,
                               "undeploy the cell and deploy it again"});
    undo_last();
  });
}

void Agent::begin_again(const Deployment& description) {
  last_refusal_.clear();
  deployment_ = description.afresh();
  log("preparing cell " + deployment_->cell.name);
  bring_up();
}

void Agent::taken_down(const Problems& problems) {
  Update& u = *update_;
  if (u.stage == Update::Stage::changing && !u.is_after) {
    u.before = deployment_->afresh();
    clear();
    if (u.undoer) {
      u.stage = Update::Stage::undoing;
      u.reasons = {fail("the update was cancelled")};
      bring_back();
    } else if (u.difference.change == Change::removed) {
      changed();
    } else {
      u.is_after = true;
      begin_again(*u.after);
    }
    return;
  }
  clear();
  if (u.stage == Update::Stage::changing) {
    u.stage = Update::Stage::undoing;
    u.reasons = problems.empty() ? Problems{fail("device " + options_.device + " has ended")} : problems;
    bring_back();
  } else if (u.is_after) {
    bring_back();
  } else {
    for (const Problem& problem : problems)
      u.left.push_back({problem.where, "it no longer runs: " + problem.what, problem.fix});
    if (u.left.empty()) u.left.push_back(fail("device " + options_.device + " no longer runs"));
    undone();
  }
}

void Agent::bring_back() {
  update_->is_after = false;
  if (update_->before)
    begin_again(*update_->before);
  else
    undone();
}

void Agent::brought_up() {
  if (update_->stage == Update::Stage::changing)
    changed();
  else
    undone();
}

}  // namespace takt::agent
