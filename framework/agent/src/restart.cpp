// Saves the deployment on disk, and restores it when the node is restarted.
#include <utility>

#include <takt/core/span.hpp>
#include "limits.hpp"
#include "update.hpp"

namespace takt::agent {

using transaction::Stage;

// Saves what this device needs after a restart of its node. During an update, these are the deployment before
// the update and the new one.
void Agent::keep_for_restart() {
  if (!options_.store) return;
  Kept kept;
  const auto add = [&](const Deployment* d) {
    if (d == nullptr || !d->transaction.complete || was_undeployed(d->id)) return;
    (d->is_final() ? kept.current : kept.pending) =
        KeptDeployment{.id = d->id,
                       .transaction = d->transaction.id,
                       .file = d->file,
                       .text = d->text,
                       .require_real_time = d->require_real_time,
                       .t0_ns = d->t0_ns,
                       .boot = options_.boot,
                       .t0_monotonic_ns = d->t0 ? to_ns(*d->t0) : 0,
                       .safe = d->safe,
                       .devices = d->transaction.devices};
  };
  add(update_ ? update_->before() : deployment_.get());
  add(update_ ? &update_->after() : gone_.get());
  options_.store->save(kept, undeployed_);
  saving_ = true;
  check_saved();
}

// Takes the result of the last save, if it is known.
void Agent::check_saved() {
  if (!saving_) return;
  const auto written = options_.store->saved();
  if (!written) return;
  saving_ = false;
  for (const WaitingAnswer& one : std::exchange(answers_, {}))
    answer(one.command, REPLY_OK, one.text, one.data);
  const bool again = std::exchange(unsaved_, !*written);
  const std::string cell = present() != nullptr ? "cell " + present()->cell.name : "the deployment";
  if (*written && again) log(cell + " is saved for --resume again");
  if (*written || again) return;
  const std::string what = (present() == nullptr ? "the end of the deployment" : cell) +
                           std::string{" could not be saved for --resume: "} + in_words(written->problems());
  log("warning: " + what);
  note({.kind = model::FaultKind::error, .cause = what});
}

void Agent::answer_when_saved(const Command& command, const std::string& text, const std::string& data) {
  if (is_saved())
    answer(command, REPLY_OK, text, data);
  else
    answers_.push_back({command, text, data});
}

// Tries again, every kDiskTriedEvery, to write the files that could not be written before. The disk may have
// space again.
void Agent::check_disk() {
  const Instant now = options_.now();
  if (now - disk_tried_at_ < kDiskTriedEvery) return;
  disk_tried_at_ = now;
  if (options_.record->reopen())
    log("the fault record is written to its file again: " + options_.record->file());
  if (unsaved_ && !saving_) keep_for_restart();
}

void Agent::restore() {
  resuming_ = false;
  const auto kept = options_.store->kept();
  if (!kept) {
    log("nothing is restored: " + in_words(kept.problems()));
    last_refusal_ = to_text(kept.problems()[0]);
    return;
  }
  for (const auto* const one : {&kept->current, &kept->pending}) {
    if (*one && !check_start(**one)) return;
  }
  if (kept->current) {
    std::unique_ptr<Deployment> current = restored(*kept->current);
    current->transaction.state.stage = Stage::final;
    if (current->has_device())
      begin(std::move(current));
    else
      set_gone(std::move(current));
  }
  if (!kept->pending) return;
  std::unique_ptr<Deployment> pending = restored(*kept->pending);
  if (auto cell = factories_.parse(pending->text, pending->file)) pending->cell = std::move(*cell);
  pending->undone = "it was undone before all devices ran";
  pending->transaction.state = {.stage = Stage::undone, .why = pending->undone};
  if (pending->update().empty())
    log("cell " + pending->cell.name + " is not restored: " + pending->undone);
  else
    log("the last update of the cell is not restored: " + pending->undone);
  set_gone(std::move(pending));
}

// Returns false, and reports this, if the start time is too far in the future. Otherwise the device would
// wait silently for it, perhaps for years if a clock is wrong.
bool Agent::check_start(const KeptDeployment& kept) {
  const Nanoseconds ahead = is_of_this_boot(kept) ? span(to_ns(options_.now()), kept.t0_monotonic_ns)
                                                  : span(options_.wall_ns(), kept.t0_ns);
  if (ahead <= transaction::kFurthestStart) return true;
  last_refusal_ = "the start time of the saved deployment is " + takt::to_text(ahead) +
                  " in the future, which is too far; set the clock of device " + options_.device +
                  ", or deploy the cell again";
  log("nothing is restored: " + last_refusal_);
  return false;
}

// The wall clock may have been set since the start time was saved, but the monotonic clock is valid until the
// next boot of the machine.
bool Agent::is_of_this_boot(const KeptDeployment& kept) const {
  return !options_.boot.empty() && kept.boot == options_.boot;
}

std::unique_ptr<Agent::Deployment> Agent::restored(const KeptDeployment& kept) const {
  auto d = std::make_unique<Deployment>();
  d->id = kept.id;
  d->transaction = {.id = kept.transaction, .devices = kept.devices, .complete = true};
  d->file = kept.file;
  d->text = kept.text;
  d->require_real_time = kept.require_real_time || options_.require_real_time;
  d->t0_ns = kept.t0_ns;
  if (kept.t0_ns != 0)
    d->t0 = is_of_this_boot(kept) ? from_ns(kept.t0_monotonic_ns) : options_.instant_of_wall(kept.t0_ns);
  d->safe = kept.safe;
  return d;
}

void Agent::report_kept() const {
  if (!options_.store) return;
  const auto kept = options_.store->kept();
  if (!kept || !kept->current || kept->current->text.empty()) return;
  const auto cell = factories_.parse(kept->current->text, kept->current->file);
  log((cell ? "cell " + cell->name : "a cell") +
      " was deployed here before and is not restored; to restore it, start the node with --resume");
}

}  // namespace takt::agent
