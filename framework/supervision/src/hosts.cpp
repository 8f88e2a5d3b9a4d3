// Starts, commands, supervises and restarts the hosts of a device.
#include <algorithm>

#include <takt/core/check.hpp>
#include <takt/core/words.hpp>
#include <takt/supervision/supervisor.hpp>
#include "fault_notes.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"
#include "properties.hpp"
#include "watch.hpp"

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
                                .error_type = static_cast<int>(type),
                                .afresh = hook == Doing::load && member.state() == State::destruct});
}

void Supervisor::take_answers(Hosted& host) {
  while (auto answer = host.process->answer()) {
    host.silent_since.reset();
    switch (answer->request.what) {
      case host::Request::Do::call: {
        Member* const member = member_at(answer->request.module);
        if (member == nullptr || member->lost || member->pending != answer->request.hook)
          break;  // the module was given up before this answer arrived
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
        host.begun = answer->ok;
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
      if (!ok && member.state() == State::destruct) {  // this load was part of a reset
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
      // While the device is prepared, all modules are initialised before the first module is started. A
      // module that is loaded again later does not wait for other modules.
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
        ask(member, Doing::start);  // start() had failed, so it must be called once more
      else
        recovered(member);
      break;
    case Doing::destruct:
      if (!ok) log(member, failure);
      if (member.machine.accepts(Event::destruct))
        apply(member, Event::destruct, member.has_finished() ? kFinished : "");
      break;
    case Doing::nothing:
    case Doing::run:
    case Doing::condition:
    case Doing::serve:
    case Doing::thread:
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
void Supervisor::check_host(Hosted& host, Instant now) {
  if (!host.process->running()) return;
  if (host.hung) {
    const Nanoseconds limit = phase_ == Phase::stopping ? kCallsLimitAtStop : kCallsLimit;
    if (now - host.hung->found > limit) host.process->kill();
    return;
  }
  const auto since = [this](const channel::Activity& activity) {
    return lasted(from_ns(activity.since_ns.load()));
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
  const bool waits = std::any_of(host.share.modules.begin(), host.share.modules.end(), [this](auto index) {
    return !members_[index]->lost && members_[index]->pending;
  });
  if (!waits || hooks.module.load(std::memory_order_relaxed) != 0) {
    host.silent_since.reset();
  } else if (!host.silent_since) {
    host.silent_since = now;
  } else if (lasted(*host.silent_since) > kAnswerLimit) {
    host.hung =
        Hang{.limit = kAnswerLimit, .text = host.name() + " did not answer within " + to_text(kAnswerLimit)};
    host.process->kill();
    return;
  }
  check_swaps(host);
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
    if (check_run(host, block.row, watches_[e].row, now)) return;
    if (check_run(host, block.sporadic, watches_[e].sporadic, now)) return;
  }
  check_rows(host, now);
}

// Ends the host if the run in progress in one of its threads hangs. Returns true in this case. A thread that
// is ready but has no CPU does not hang: another thread keeps the CPU from it, and may hang.
bool Supervisor::check_run(Hosted& host, const channel::Activity& activity, Watch& watch, Instant now) {
  const Member* const busy = member_at(activity.module.load(std::memory_order_acquire) - 1);
  const std::int64_t since_ns = activity.since_ns.load();
  const Nanoseconds lasted = this->lasted(from_ns(since_ns));
  const Nanoseconds limit = busy == nullptr ? Nanoseconds{0} : model::hang_limit(busy->model);
  if (busy == nullptr || lasted < limit / 4) {
    watch = {};
    return false;
  }
  const Nanoseconds seen = watch.look(static_cast<std::uint64_t>(since_ns), passed_, limit,
                                      platform_->ran_if_ready(activity.thread.load()));
  if (lasted < limit || seen < limit / 2) return false;
  host.hung = Hang::of_call(busy->index, activity, limit, now);
  host.process->end_by(host.hung->thread);
  return true;
}

// Kills the host if one of its executors runs no rows, although no run keeps it from doing so. The host may
// be stopped, for example. The time in which another process keeps the CPU from the executor does not count.
void Supervisor::check_rows(Hosted& host, Instant now) {
  if (phase_ != Phase::running || !host.begun || now < *t0_) return;
  for (const std::size_t e : host.share.executors) {
    const Nanoseconds basic = parts_.plan.executors[e].basic_period;
    const Nanoseconds limit = stands_after(basic);
    const channel::ExecutorBlock& block = parts_.channel.executor(e);
    const std::uint64_t cycles = block.cycles.load(std::memory_order_relaxed);
    Watch& watch = watches_[e].cycles;
    const Nanoseconds stood =
        watch.look(cycles, passed_, limit, ran_if_starved(watch, limit, block.row.thread.load()));
    if (basic == Nanoseconds{0} || stood < limit || has_long_run(now)) continue;
    host.hung = Hang{.limit = limit,
                     .text = "executor " + device().executors[e].name + " ran no row for " + to_text(limit)};
    host.process->kill();
    return;
  }
}

// Returns the CPU time of a thread if the thread is ready to run and its watch has reached a quarter of its
// limit. Earlier, the time is not needed, and reading it takes a while.
std::optional<Nanoseconds> Supervisor::ran_if_starved(const Watch& watch, Nanoseconds limit,
                                                      std::int32_t thread) const {
  return watch.seen_for() < limit / 4 ? std::nullopt : platform_->ran_if_ready(thread);
}

// True if a run or a body has lasted so long that it may keep other threads from their CPU. Then the caller
// waits, because the hang limit of that run or body applies first. A run that has lasted twice its hang limit
// does not count: it was not ended as a hang, so it has no CPU itself.
bool Supervisor::has_long_run(Instant now) const {
  const auto is_long = [now](const Member& member, std::int64_t since_ns) {
    const Nanoseconds lasted = now - from_ns(since_ns);
    return lasted >= kLongRun && lasted / 2 < model::hang_limit(member.model);
  };
  for (std::size_t e = 0; e < parts_.channel.executors(); ++e) {
    const channel::ExecutorBlock& block = parts_.channel.executor(e);
    for (const channel::Activity* activity : {&block.row, &block.sporadic}) {
      const Member* const busy = member_at(activity->module.load(std::memory_order_acquire) - 1);
      if (busy != nullptr && is_long(*busy, activity->since_ns.load())) return true;
    }
  }
  return std::any_of(members_.begin(), members_.end(), [&is_long](const auto& member) {
    const channel::ReleaseSlot* const slot = member->slot;
    return slot != nullptr && slot->in_body() && is_long(*member, slot->release_ns.load());
  });
}

// Returns the activities of the host's threads that call run() or condition().
std::vector<const channel::Activity*> Supervisor::runs_of(const Hosted& host) const {
  std::vector<const channel::Activity*> activities;
  for (const std::size_t e : host.share.executors) {
    activities.push_back(&parts_.channel.executor(e).row);
    activities.push_back(&parts_.channel.executor(e).sporadic);
  }
  for (const std::uint32_t index : host.share.modules)
    activities.push_back(&members_[index]->block.background);
  return activities;
}

// Returns the activity of the thread that was in a hook when the host ended; null if there was none, or more
// than one.
const channel::Activity* Supervisor::only_activity(const Hosted& host) const {
  std::vector<const channel::Activity*> activities = runs_of(host);
  activities.insert(activities.end(), {&host.block.hooks, &host.block.swap});
  for (const std::uint32_t index : host.share.modules) activities.push_back(&members_[index]->block.service);
  std::erase_if(activities, [](const channel::Activity* each) { return each->module.load() == 0; });
  return activities.size() == 1 ? activities[0] : nullptr;
}

// Finds a module that keeps a thread of the host busy although all executors were told to halt.
std::optional<Hang> Supervisor::never_halts(const Hosted& host, Instant now) const {
  for (const channel::Activity* activity : runs_of(host)) {
    if (const Member* const busy = member_at(activity->module.load(std::memory_order_acquire) - 1))
      return Hang::of_call(busy->index, *activity, kHaltLimit, now);
  }
  return std::nullopt;
}

// Clears the activities of the threads of an ended host. No other process writes to these blocks now.
namespace {
void clear_after(channel::HostBlock& block) {
  block.crash.signal.store(0);
  block.crash.module.store(0);
  block.crash.depth.store(0);
  block.crash.exception = {};
  block.hooks.end();
  block.swap.end();
}
void clear_after(channel::ExecutorBlock& executor) {
  executor.row.end();
  executor.sporadic.end();
  executor.row_sequence.store(executor.row_sequence.load() & ~std::uint64_t{1});
}
}  // namespace

// Returns the calls in which a module crashed or hung.
CrashCalls Supervisor::calls_of(Hosted& host, const Member& culprit) {
  // A thread that hangs may not have reported its calls.
  if (host.block.crash.module.load() != culprit.index + 1) return {};
  CrashCalls calls = host.process->calls_of_crash(culprit.index);
  if (host.hung && !calls.place.empty()) {
    calls.place = std::string{"; "} + channel::to_text(host.hung->doing) + " was" + calls.place.substr(1);
  }
  return calls;
}

void Supervisor::host_ended(Hosted& host, const ProcessEnd& end) {
  properties_->fail(host, host.name() + " of device " + device().name + " has ended");
  platform_->wake(~0U);  // the host may have written samples without waking their readers
  if (phase_ == Phase::ended || (phase_ == Phase::stopping && end_asked_)) return;
  std::string text = host.name() + " " + end.text;
  Member* culprit = nullptr;
  const ErrorType type = host.hung ? ErrorType::hang : ErrorType::crash;
  const channel::Crash& crash = host.block.crash;
  host.silent_since.reset();
  Doing doing = Doing::nothing;
  if (host.hung) {
    doing = host.hung->doing;
    if (host.hung->module) culprit = members_[*host.hung->module].get();
    text = host.hung->text + ", so the node killed " + host.name();
  } else if (crash.signal.load() == (end.signalled ? end.code : channel::Crash::kExit)) {
    culprit = member_at(crash.module.load() - 1);
    doing = crash.doing.load();
    if (culprit != nullptr) text += std::string{" in "} + channel::to_text(doing);
  } else if (const channel::Activity* const last = !end.signalled ? only_activity(host) : nullptr;
             last != nullptr) {
    culprit = member_at(last->module.load() - 1);
    doing = last->doing.load();
    text +=
        std::string{" in "} + channel::to_text(doing) + ", which made the system call exit_group() itself";
  }
  const bool swapped = culprit != nullptr && by_swap(*culprit, doing);
  if (swapped) text += " of its new instance";
  if (!host.hung && !crash.exception.empty()) {
    text += ", because nothing caught the exception '" + on_one_line(crash.exception.view()) +
            "' (none can leave a noexcept function)";
  }
  if (swapped) {
    const CrashCalls calls = calls_of(host, *culprit);
    text += calls.place + calls.callers;
    end_swap(*culprit, REPLY_FAILED, "the old instance is loaded again: " + text);
    culprit = nullptr;
  }
  const CrashCalls calls = culprit != nullptr ? calls_of(host, *culprit) : CrashCalls{};
  text += calls.place;
  const std::string reason = culprit == nullptr ? text : "module " + culprit->model.name + ": " + text;
  log(reason);
  const auto since = host.hung ? std::optional{time() - host.hung->limit} : std::nullopt;
  host.hung.reset();

  // The module crashed or hung in its first run, which running_step() has not noticed yet.
  if (culprit != nullptr && (doing == Doing::run || doing == Doing::condition) &&
      culprit->state() == State::start && culprit->in_tables()) {
    apply(*culprit, Event::run);
  }
  if (culprit == nullptr) platform_->fault(text);
  platform_->host_died(host.share);
  clear_after(host.block);
  host.begun = false;
  for (const std::size_t e : host.share.executors) {
    clear_after(parts_.channel.executor(e));
    watches_[e] = {};
  }
  for (const std::uint32_t index : host.share.modules) {
    Member& member = *members_[index];
    member.block.background.end();
    member.block.service.end();
    member.block.on_trial.store(0);
    end_swap(member, REPLY_FAILED, reason + "; the old instance is loaded again");
    take_from_tables(member);
    if (&member != culprit) member.pending.reset();  // the host cannot answer any more
  }

  if (culprit != nullptr) {
    // An error in IDLE, RECOVER or DESTRUCT takes no step of the lifecycle, so count the error here. apply()
    // counts every other error.
    if (!culprit->machine.accepts(Event::error)) ++culprit->errors;
    crashed(*culprit, text, type, since, calls.callers, end.core);
  } else if (phase_ == Phase::preparing) {
    fail_device({"device " + device().name, text, "read its output above"});
  }
  if (phase_ == Phase::stopping) {
    host.halted = true;
    for (const std::uint32_t index : host.share.modules)
      members_[index]->lost = true;  // the module's instance ended with the host
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

// Fails the commands to modules of an ended host, because the host can no longer answer. step_command() ends
// the command to the culprit, as it ends every command during which an error occurs.
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

// Handles a module whose crash ended its host. A module in the shared host is given up, because a second
// crash would also stop the other modules, which are not at fault.
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

// Gives up a host that ended repeatedly without a module that was found to be at fault.
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
