// Decides between two nodes with one device name, so that only one of them executes.
//
// A node that executes keeps the device. If both execute, each of them began while it could not hear the
// other. Each node counts how long it has executed in contact with the other devices of the cell, and the
// node with the longer time keeps the device. A node that was cut off, or that began while it was cut off,
// starts to count when it is back.
#include <algorithm>
#include <utility>

#include <takt/wire/words.hpp>
#include "limits.hpp"
#include "update.hpp"

namespace takt::agent {

using Phase = Supervised::Phase;

// Reports another node with this device name, and gives way to it if it keeps the device. Otherwise restores
// the deployment when it is time.
void Agent::check_names() {
  std::optional<DeviceStatus> twin;
  for (const auto& [status, alive] : others_.of_device(options_.device)) {
    if (!alive || status.node() == options_.node) continue;
    if (!twin || (wire::executes(status) && !wire::executes(*twin))) twin = status;
  }
  const std::string found =
      twin ? twin->node().to_string() + (wire::executes(*twin) ? " executes" : "") : std::string{};
  name_clash_ = twin ? wire::name_conflict(*twin, options_.domain) : "";
  if (std::exchange(twin_, found) != found) {
    log(twin ? name_clash_ +
                   "; end or rename one of them: while both run, they reject deployments and commands"
             : "the other node with this name is gone");
    // The other node may have published states of modules with the same names.
    if (!twin && deployment_) {
      for (const LifecycleStatus& module : deployment_->modules) publisher_.publish(module);
    }
  }
  const bool both_execute = twin && wire::executes(*twin) && deployment_ && deployment_->supervised &&
                            deployment_->supervised->phase() == Phase::running;
  if (!both_execute)
    both_execute_since_.reset();
  else if (!both_execute_since_)
    both_execute_since_ = options_.now();
  if (twin && (present() != nullptr || resuming_) && gives_way_to(*twin))
    give_way();
  else
    check_resume();
}

// The other devices of the cell decide which of two nodes was cut off. A cell with one device is never cut
// off.
void Agent::check_interruption() {
  const bool executes =
      deployment_ && deployment_->supervised && deployment_->supervised->phase() == Phase::running;
  bool in_contact = executes && deployment_->cell.devices.size() == 1;
  if (executes) {
    for (const auto& other : others_.of_deployment(deployment_->id, options_.device))
      in_contact |= other.alive;
  }
  if (!in_contact)
    uninterrupted_since_.reset();
  else if (!uninterrupted_since_)
    uninterrupted_since_ = options_.now();
}

std::chrono::seconds Agent::uninterrupted() const {
  if (!uninterrupted_since_) return std::chrono::seconds{0};
  return std::chrono::duration_cast<std::chrono::seconds>(options_.now() - *uninterrupted_since_);
}

// Returns true if the other node, which has the same name, keeps the device, so that this node must not
// execute. Both nodes decide this by the same published numbers.
bool Agent::gives_way_to(const DeviceStatus& other) const {
  const DeviceState state = other.state();
  if (present() == nullptr) return state != DEVICE_WAITING;
  const bool has_smaller_id = other.node().to_string() < options_.node;
  if (!deployment_ || !deployment_->supervised || deployment_->supervised->phase() != Phase::running) {
    const bool begins = state == DEVICE_PREPARING || state == DEVICE_READY || state == DEVICE_ARMED;
    return wire::executes(other) || state == DEVICE_STOPPING || (begins && has_smaller_id);
  }
  if (!both_execute_since_) return false;
  const std::chrono::seconds theirs{other.uninterrupted_s()};
  const std::chrono::seconds mine = uninterrupted();
  if (theirs > mine + kSameAge) return true;
  // The received number is old, so the two nodes may not agree who is older. The ids decide later, so that a
  // node that has given way by its age is no longer there.
  return mine <= theirs + kSameAge && options_.now() - *both_execute_since_ > kSameAge && has_smaller_id;
}

void Agent::give_way() {
  if (present() == nullptr) {
    if (!waits_since_) {
      waits_since_ = options_.now();
      log("this node waits and does not restore its deployment, until the other node has been gone for " +
          takt::to_text(kTwinBack));
    }
    const bool lives = options_.now() - *waits_since_ > kRemains;
    resume_at_ = std::max(resume_at_, options_.now() + (lives ? kTwinBack : Nanoseconds{0}));
    return;
  }
  const Deployment& d = *present();
  const bool is_over = d.over || !d.undone.empty() || !d.undeployers.empty() || ending_;
  if (is_over || (d.supervised && d.supervised->phase() >= Phase::stopping)) return;
  if (update_ && update_->is_deployment() && !both_execute_since_) return update_->undo({fail(name_clash_)});
  if (!d.supervised) {
    deployment_.reset();
    resume();
    return;
  }
  const std::string why =
      name_clash_ + ", while this node was cut off or began later; this node stops and ends";
  log(why);
  note({.kind = model::FaultKind::device_failed, .cause = why});
  has_given_way_ = true;
  end(false);
}

void Agent::resume() {
  if (!options_.store) return;
  resuming_ = true;
  waits_since_.reset();
  resume_at_ = options_.now() + (options_.cell.empty() ? kTwinFound : kTwinFoundSecured);
}

void Agent::check_resume() {
  if (!resuming_ || ending_ || options_.now() <= resume_at_) return;
  resuming_ = false;
  restore();
}

}  // namespace takt::agent
