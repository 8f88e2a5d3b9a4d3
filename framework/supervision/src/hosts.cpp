// Starts, commands, supervises and restarts the hosts of a device.
#include <algorithm>

#include <takt/core/check.hpp>
#include <takt/supervision/supervisor.hpp>
#include "fault_notes.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"
#include "properties.hpp"

namespace takt::supervision {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

Hosted& Supervisor::host_of(const Member& member) const { return *hosts_[member.host]; }

void Supervisor::ask(Member& member, Doing hook, ErrorType type) {
  TAKT_CHECK(!member.lost);
  member.pending = hook;
  host_of(member).process->ask({.what = host::Request::Do::call,
                                .module = member.index,
                                .hook = hook,
                                .error_type = static_cast<int>(type)});
}

void Supervisor::take_answers(Hosted& host) {
  while (auto answer = host.process->answer()) {
    switch (answer->request.what) {
      case host::Request::Do::call: {
        Member* const member = member_at(answer->request.module);
        if (member == nullptr || member->lost || member->pending != answer->request.hook)
          break;  // the module was given up in the meantime
        member->pending.reset();
        answered(*member, answer->request.hook, answer->ok, answer->text);
        break;
      }
      case host::Request::Do::get:
      case host::Request::Do::set:
        property_answered(*answer);
        break;
      case host::Request::Do::swap:
        if (Member* const member = member_at(answer->request.module))
          end_swap(*member, answer->ok ? REPLY_OK : REPLY_FAILED, answer->text);
        break;
      case host::Request::Do::begin:
        for (const std::string& warning : answer->warnings) {
          parts_.real_time = false;
          log("WARNING: not real-time: " + warning);
        }
        if (!answer->ok) fail_device(fail(answer->text));
        break;
      case host::Request::Do::halt:
        host.halted = true;
        break;
      case host::Request::Do::background:
      case host::Request::Do::give_up:
      case host::Request::Do::give_up_swap:
      case host::Request::Do::end:
        break;
    }
  }
}

void Supervisor::answered(Member& member, Doing hook, bool ok, const std::string& text) {
  const std::string failure = std::string{channel::to_text(hook)} + " failed: " + text;
  switch (hook) {
    case Doing::load:
      if (!ok && member.state() == State::destruct) {  // during a reset
        member.lost = true;
        member.why = failure;
      } else if (!ok && member.reload) {
        not_recovered(member, failure);
      } else if (!ok) {
        lose(member, failure);
      } else {
        if (member.state() == State::destruct) apply(member, Event::reset);
        if (member.up_to != State::idle) ask(member, Doing::initialize);
      }
      break;
    case Doing::initialize:
      if (ok && !text.empty()) log(member, text);
      if (member.reload) {
        if (ok)
          ask(member, Doing::start);
        else
          not_recovered(member, failure);
        break;
      }
      if (!ok) {
        lose(member, failure);
        break;
      }
      apply(member, Event::initialize);
      // While the device is prepared, all modules are initialised before the first is started. A module that
      // comes back later does not wait for others.
      if ((phase_ == Phase::ready || phase_ == Phase::running) && member.up_to != State::initialize)
        ask(member, Doing::start);
      break;
    case Doing::start:
      if (ok && member.state() == State::recover) {
        recovered(member);
      } else if (ok) {
        apply(member, Event::start);
        if (rows_begun_ && member.wanted()) put_in_tables(member);
      } else if (member.state() == State::recover) {
        not_recovered(member, failure);
      } else {
        raise(member, ErrorType::start, failure);
      }
      break;
    case Doing::error:
      if (!ok) log(member, failure);
      break;
    case Doing::recover:
      if (!ok)
        not_recovered(member, failure);
      else if (member.machine.previous() == State::initialize)
        ask(member, Doing::start);  // start() had failed
      else
        recovered(member);
      break;
    case Doing::destruct:
      if (!ok) log(member, failure);
      if (member.machine.accepts(Event::destruct)) apply(member, Event::destruct);
      break;
    case Doing::nothing:
    case Doing::run:
    case Doing::condition:
    case Doing::serve:
      break;
  }
}

void Supervisor::begin_rows() {
  for (auto& member : members_) {
    if (member->scheduled() && member->wanted() && member->state() == State::start) put_in_tables(*member);
  }
  rows_begun_ = true;
  for (const auto& host : hosts_) host->process->ask({.what = host::Request::Do::begin});
}

// Detects a run() or a hook that does not return.
void Supervisor::watch_host(Hosted& host, Instant now) {
  if (!host.process->running() || host.hung) return;
  const auto since = [now](const channel::Activity& activity) {
    return now - from_ns(activity.since_ns.load());
  };

  const channel::Activity& hooks = host.block.hooks;
  if (Member* const member = member_at(hooks.module.load(std::memory_order_acquire) - 1);
      member != nullptr && since(hooks) > kHookLimit) {
    const Doing doing = hooks.doing.load();
    if (member->pending == doing) {
      host.process->ask({.what = host::Request::Do::give_up, .module = member->index});
      lose(*member, std::string{channel::to_text(doing)} + " did not return within " + to_text(kHookLimit),
           ErrorType::hang);
    }
  }
  watch_swaps(host, now);
  for (const std::uint32_t index : host.share.modules) {
    Member& member = *members_[index];
    const channel::Activity& service = member.block.service;
    if (service.module.load(std::memory_order_acquire) == 0 || since(service) <= kHookLimit || member.lost)
      continue;
    host.process->ask({.what = host::Request::Do::give_up, .module = index});
    lose(member, "the handler of a service did not return within " + to_text(kHookLimit), ErrorType::hang);
  }
  for (const std::size_t e : host.share.executors) {
    const channel::ExecutorBlock& block = parts_.channel.executor(e);
    for (const channel::Activity* activity : {&block.row, &block.sporadic}) {
      const Member* const busy = member_at(activity->module.load(std::memory_order_acquire) - 1);
      if (busy == nullptr || since(*activity) < stuck_after(busy->model)) continue;
      host.hung = {.module = busy->index, .doing = activity->doing.load(), .limit = stuck_after(busy->model)};
      host.process->kill();
      return;
    }
  }
}

// Finds a module that still keeps a thread of the host busy, long after all executors were told to halt.
std::optional<Hang> Supervisor::never_halts(const Hosted& host) const {
  std::vector<const channel::Activity*> activities;
  for (const std::size_t e : host.share.executors) {
    activities.push_back(&parts_.channel.executor(e).row);
    activities.push_back(&parts_.channel.executor(e).sporadic);
  }
  for (const std::uint32_t index : host.share.modules)
    activities.push_back(&members_[index]->block.background);
  for (const channel::Activity* activity : activities) {
    if (const Member* const busy = member_at(activity->module.load(std::memory_order_acquire) - 1))
      return Hang{.module = busy->index, .doing = activity->doing.load(), .limit = kHaltLimit};
  }
  return std::nullopt;
}

// Clears what the threads of an ended host were doing. Nothing else writes to its blocks now.
namespace {
void clear_after(channel::HostBlock& block) {
  block.crash.signal.store(0);
  block.crash.module.store(0);
  block.crash.depth.store(0);
  block.hooks.end();
  block.swap.end();
}
void clear_after(channel::ExecutorBlock& executor) {
  executor.row.end();
  executor.sporadic.end();
  executor.row_sequence.store(executor.row_sequence.load() & ~std::uint64_t{1});
}
}  // namespace

void Supervisor::host_ended(Hosted& host, const ProcessEnd& end) {
  properties_->fail(host, host.name() + " of device " + device().name + " has ended");
  platform_->wake(~0U);  // it may have written samples without waking their readers
  if (phase_ == Phase::ended || (phase_ == Phase::stopping && end_asked_)) return;
  std::string text = host.name() + " " + end.text;
  Member* culprit = nullptr;
  const ErrorType type = host.hung ? ErrorType::hang : ErrorType::crash;
  const channel::Crash& crash = host.block.crash;
  if (host.hung) {
    culprit = members_[host.hung->module].get();
    text = std::string{channel::to_text(host.hung->doing)} + " did not return within " +
           to_text(host.hung->limit) + ", so the node killed " + host.name();
  } else if (crash.signal.load() == (end.signalled ? end.code : channel::Crash::kExit)) {
    culprit = member_at(crash.module.load() - 1);
    if (culprit != nullptr) text += std::string{" in "} + channel::to_text(crash.doing.load());
  }
  const Doing doing = host.hung ? host.hung->doing : crash.doing.load();
  const bool swapped = culprit != nullptr && by_swap(*culprit, doing);
  if (swapped) {
    const CrashCalls calls = host.hung ? CrashCalls{} : host.process->calls_of_crash(culprit->index);
    text += " of its new instance" + calls.place + calls.callers;
    end_swap(*culprit, REPLY_FAILED, "the old instance is loaded again: " + text);
    culprit = nullptr;
  }
  const bool crashed_itself = culprit != nullptr && type == ErrorType::crash;
  const CrashCalls calls = crashed_itself ? host.process->calls_of_crash(culprit->index) : CrashCalls{};
  text += calls.place;
  const std::string reason = culprit == nullptr ? text : "module " + culprit->model.name + ": " + text;
  log(reason);
  const auto since = host.hung ? std::optional{time() - host.hung->limit} : std::nullopt;
  host.hung.reset();

  // It crashed in its first run, and running_step() has not seen that run yet.
  if (culprit != nullptr && (doing == Doing::run || doing == Doing::condition) &&
      culprit->state() == State::start && culprit->in_tables()) {
    apply(*culprit, Event::run);
  }
  if (culprit == nullptr) platform_->fault(text);
  platform_->host_died(host.share);
  clear_after(host.block);
  for (const std::size_t e : host.share.executors) clear_after(parts_.channel.executor(e));
  for (const std::uint32_t index : host.share.modules) {
    Member& member = *members_[index];
    member.block.background.end();
    member.block.service.end();
    member.block.on_trial.store(0);
    end_swap(member, REPLY_FAILED, reason + "; the old instance is loaded again");
    take_from_tables(member);
    if (&member != culprit) member.pending.reset();  // no answer will come
  }

  if (culprit != nullptr) {
    ++culprit->errors;
    crashed(*culprit, text, type, since, calls.callers, end.core);
  } else if (phase_ == Phase::preparing) {
    fail_device({"device " + device().name, text, "read its output above"});
  }
  if (phase_ == Phase::stopping) {
    host.halted = true;
    for (const std::uint32_t index : host.share.modules)
      members_[index]->lost = true;  // its instance is lost
    return;
  }
  if (culprit == nullptr && !swapped) {
    const Instant now = time();
    std::erase_if(host.restarts, [now](Instant then) { return now - then > kRestartWindow; });
    host.restarts.push_back(now);
    if (host.restarts.size() > kHostRestarts) {
      give_up_host(host, text);
      return end_commands_of(host, culprit, reason);
    }
  }
  notes_->note(model::FaultKind::host_restart, text);
  restart_host(host);
  end_commands_of(host, culprit, reason);
}

// Fails the commands to modules of an ended host, which can no longer answer. A command to the culprit ends
// like any other command that meets an error.
void Supervisor::end_commands_of(const Hosted& host, const Member* culprit, const std::string& why) {
  for (const std::uint32_t index : host.share.modules) {
    Member& member = *members_[index];
    if (!member.command || &member == culprit) continue;
    const bool loaded = member.state() != State::destruct && member.state() != State::recover;
    const std::string follows =
        loaded ? std::string{"it is loaded again and goes to "} + lifecycle::to_text(member.up_to)
               : std::string{"it is in "} + lifecycle::to_text(member.state()) + what_follows(member);
    end_command(member, REPLY_FAILED, why + "; " + follows);
  }
}

void Supervisor::restart_host(Hosted& host) {
  if (auto started = host.process->start(); !started) {
    fail_device(started.problems()[0]);
    return;
  }
  ++host_restarts_;
  log(host.name() + " is started again");
  for (const std::uint32_t index : host.share.modules) {
    Member& member = *members_[index];
    if (!member.lost && !member.reload && member.state() != State::destruct) bring_back(member);
  }
  if (rows_begun_) host.process->ask({.what = host::Request::Do::begin});
  if (background_begun_) host.process->ask({.what = host::Request::Do::background});
}

// Handles a module whose crash ended its host. In the shared host, the module is given up, because another
// crash would stop the other modules again, which are not at fault.
void Supervisor::crashed(Member& member, const std::string& text, ErrorType type,
                         std::optional<Instant> since, const std::string& callers, const std::string& core) {
  const bool ending = phase_ == Phase::stopping || member.pending == Doing::destruct;
  member.pending.reset();
  const bool starting = phase_ == Phase::preparing || phase_ == Phase::ready;
  if (!host_of(member).share.is_own() || starting || ending) return lose(member, text, type, callers, core);
  const bool recovering = member.state() == State::recover;
  if (!recovering && !member.machine.accepts(Event::error)) return lose(member, text, type, callers, core);
  notes_->note(member, model::FaultKind::error, text + callers, type, core);
  member.reload = true;
  if (recovering) return not_recovered(member, text);
  member.why = std::string{takt::to_text(type)} + ": " + text;
  member.stale = false;
  apply(member, Event::error, member.why, type);
  member.recovery.failed(time(), since);
}

// Gives up a host that ended repeatedly, although no module was found to be at fault.
void Supervisor::give_up_host(Hosted& host, const std::string& text) {
  const std::string why = text + "; it has been restarted " + std::to_string(kHostRestarts) + " times";
  if (!host.share.is_own()) {
    fail_device({"device " + device().name, why, "read its output above"});
    host.halted = true;
    for (const std::uint32_t index : host.share.modules) members_[index]->lost = true;
    return;
  }
  log(host.name() + " is given up; the other hosts continue; to restart it, reset one of its modules");
  for (const auto* of : {&host.share.modules, &host.share.programs}) {
    for (const std::uint32_t index : *of) {
      Member& member = *members_[index];
      if (!member.lost && member.state() != State::destruct) lose(member, why, ErrorType::crash);
      if (member.runs()) member.program->kill();
    }
  }
}

// Reloads a module that was lost when its host ended, although the module was not at fault.
void Supervisor::bring_back(Member& member) {
  member.pending.reset();
  member.block.error.store(0);
  apply(member, Event::destruct, "its host ended");
  apply(member, Event::reset);
  ask(member, Doing::load);
}

}  // namespace takt::supervision
