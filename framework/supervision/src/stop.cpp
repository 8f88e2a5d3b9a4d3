// Shuts a device down: rows end, modules stop, destruct() is called, programs end, and the hosts end.
#include <algorithm>

#include <takt/supervision/supervisor.hpp>
#include "forces.hpp"
#include "health.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

void Supervisor::stop() {
  if (phase_ == Phase::stopping || phase_ == Phase::ended) return;
  health_->stop(time());
  phase_ = Phase::stopping;
  asked_at_ = time();
  for (auto& member : members_) {
    member->up_to = State::start;
    forces_->end_all(*member, "the device stops");
    if (member->command) end_command(*member, REPLY_FAILED, "the device is stopping");
  }
  // The modules stay in the tables until the last row has ended, so that no row runs without them.
  for (const auto& host : hosts_)
    host->halted = !host->process->running() || !host->process->ask({.what = host::Request::Do::halt});
}

void Supervisor::stopping_step(Instant now) {
  bool halted = true;
  for (const auto& host : hosts_) {
    if (host->halted) continue;
    halted = false;
    if (lasted(asked_at_) <= kHaltLimit || !host->process->running() || host->hung || host->killed) continue;
    host->hung = never_halts(*host, now);
    if (host->hung) {
      host->process->end_by(host->hung->thread);
      continue;
    }
    log("the executors of " + host->name() + " did not halt within " + to_text(kHaltLimit) +
        "; the node kills the host");
    host->killed = true;  // it ends soon, but not at once
    host->process->kill();
  }
  if (!halted) return;
  bool all = true;
  for (auto& member : members_) {
    take_from_tables(*member);
    destruct(*member, now);
    all &= member->state() == State::destruct && !member->runs();
  }
  if (!all) {
    asked_at_ = now;
    return;
  }
  if (!end_asked_) {
    end_asked_ = true;
    for (const auto& host : hosts_) host->process->ask({.what = host::Request::Do::end});
  }
  bool running = false;
  for (const auto& host : hosts_) {
    if (host->process->running() && lasted(asked_at_) > kHostEndLimit) host->process->kill();
    running |= host->process->running();
  }
  if (running) return;
  // It may take long to write the last files, and the node's thread must not wait for this.
  if (!platform_->finish() && now - asked_at_ < kHostEndLimit + kWrittenWithin) return;
  platform_->step(now);
  report_detections();
  for (Problem& problem : platform_->final_problems()) failures_.push_back(std::move(problem));
  if (rows_begun_) health_->finish(now);
  phase_ = Phase::ended;
}

void Supervisor::destruct(Member& member, Instant now) {
  if (member.is_process()) {
    if (member.runs()) {
      end_process(member, now);  // a process module has no destruct(), so its process ends instead
    } else if (member.state() != State::destruct) {
      if (member.machine.accepts(Event::stop)) apply(member, Event::stop);
      apply(member, Event::destruct);
    }
    return;
  }
  if (member.state() == State::destruct || member.pending) return;
  if (member.machine.accepts(Event::stop)) apply(member, Event::stop);
  if (member.lost || member.reload || !host_of(member).process->running() || member.state() == State::idle) {
    apply(member, Event::destruct, member.has_finished() ? kFinished : "");
  } else {
    ask(member, Doing::destruct);
  }
}

}  // namespace takt::supervision
