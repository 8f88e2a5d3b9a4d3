// Starts, monitors and ends the programs of process modules, real-time or not.
#include <algorithm>
#include <utility>

#include <takt/supervision/supervisor.hpp>
#include "limits.hpp"
#include "member.hpp"
#include "properties.hpp"

namespace takt::supervision {

using lifecycle::Event;
using lifecycle::State;

namespace {

const char* wait_function(const Member& member) {
  return member.model.operation == model::Operation::periodic ? "waitPeriod()" : "waitSporadic()";
}

const char* init_function(const Member& member) {
  return member.model.operation == model::Operation::periodic ? "initPeriodExe()" : "initSporadicExe()";
}

}  // namespace

void Supervisor::fill_slot(Member& member) {
  channel::ReleaseSlot& slot = *member.slot;

  const schedule::ExecutorPlan& plan = parts_.plan.executors[executor_of(member)];
  const bool periodic = member.model.operation == model::Operation::periodic;
  const Nanoseconds period =
      periodic ? *member.model.period : plan.basic_period;  // any row can release a sporadic module
  slot.magic = channel::ReleaseSlot::kMagic;
  slot.name.assign(member.model.name);
  slot.kind = periodic ? channel::ReleaseSlotKind::periodic : channel::ReleaseSlotKind::sporadic;
  slot.wake_bit = channel::wake_bit(member.index);
  slot.period_ns = period.count();
  if (periodic) slot.offset_ns = schedule::offset_of(plan, member.index).count();
  slot.logical = model::timing_of(device(), member.model) == model::Timing::let ? 1 : 0;
  // Process modules that spin for their releases on the same CPU share the spin limit of one module equally.
  slot.margin_cap_ns = platform_->spin_limit(member.model, period).count() /
                       schedule::programs_on_one(device(), parts_.placement);
  if (const auto contract = model::contract_of(device(), member.model);
      contract.what == model::Overrun::catch_up) {
    slot.catch_up = static_cast<std::uint32_t>(contract.limit);
  }
  slot.lock_memory = parts_.real_time ? 1 : 0;
  slot.deadline_ns = member.model.deadline.value_or(Nanoseconds{0}).count();
  slot.immediate = member.model.dispatch == model::Dispatch::immediate ? 1 : 0;
  slot.interarrival_ns = member.model.interarrival.value_or(Nanoseconds{0}).count();
}

Result<void> Supervisor::spawn(Member& member) {
  if (member.slot != nullptr) channel::clear_for_new_program(*member.slot);
  if (auto started = member.program->start(); !started) return started;
  member.spawned = time();
  member.hung.clear();
  member.told_to_end = {};
  member.end_signals = 0;
  return {};
}

// Gives a real-time priority to the thread of a process module that waits for releases. The thread gets it
// only when the module is ready, so that the module's preparation cannot starve other processes.
void Supervisor::process_ready(Member& member) {
  if (!parts_.real_time) return;
  const auto made = member.program->make_real_time();
  if (made) return;
  parts_.real_time = false;
  log(member, "WARNING: not real-time: " + in_words(made.problems()));
}

void Supervisor::check_process(Member& member) {
  if (const auto end = member.program->ended()) {
    // The program may have made more progress before its end than the last check showed.
    if (member.state() == State::idle &&
        member.slot->phase.load(std::memory_order_acquire) != channel::ReleaseSlotPhase::empty) {
      apply(member, Event::initialize);
    }
    if (member.state() == State::start && member.in_tables() && cycles_of(member) != member.seen_cycles)
      apply(member, Event::run);
    process_ended(member, *end);
    return;
  }
  if (!member.runs() || !member.scheduled() || phase_ == Phase::stopping) return;

  const channel::ReleaseSlotPhase phase = member.slot->phase.load(std::memory_order_acquire);
  const bool slow = lasted(member.spawned) > kAttachLimit;
  switch (member.state()) {
    case State::idle:
      if (phase != channel::ReleaseSlotPhase::empty)
        apply(member, Event::initialize);
      else if (slow)
        lose(member,
             std::string{"did not call "} + init_function(member) + " within " + to_text(kAttachLimit),
             ErrorType::hang);
      break;
    case State::initialize:
      if (phase != channel::ReleaseSlotPhase::ready && slow) {
        lose(member,
             std::string{"did not call "} + wait_function(member) + " within " + to_text(kAttachLimit),
             ErrorType::hang);
      } else if (phase == channel::ReleaseSlotPhase::ready && phase_ == Phase::running && member.wanted()) {
        process_ready(member);  // during preparation, prepare_step() makes this call
        apply(member, Event::start);
        put_in_tables(member);
      }
      break;
    case State::recover:
      if (!member.started_again) {
        check_body(member);
      } else if (phase == channel::ReleaseSlotPhase::ready && member.hung.empty()) {
        process_ready(member);
        recovered(member);
      } else if (slow) {
        member.program->kill();
      }
      break;
    case State::start:
    case State::executing:
      check_body(member);
      break;
    case State::destruct:
      break;
  }
}

// Detects a body that does not end, or that ended after its deadline.
void Supervisor::check_body(Member& member) {
  channel::ReleaseSlot& slot = *member.slot;
  if (!member.hung.empty()) return;
  // Read in_body() before release_ns. In the opposite order, a body that has just begun would be judged by
  // the time of the previous release.
  const Nanoseconds limit = hang_limit(member.model);
  const bool in_body = slot.in_body();
  const std::int64_t release_ns = slot.release_ns.load(std::memory_order_acquire);
  if (!in_body) member.body = {};
  const Nanoseconds seen =
      in_body ? member.body.look(static_cast<std::uint64_t>(release_ns), passed_, limit) : Nanoseconds{0};
  if (in_body && lasted(from_ns(release_ns)) >= limit && seen >= limit / 2) {
    member.hung = std::string{"did not return to "} + wait_function(member) + " within " + to_text(limit);
    member.program->kill();
    return;
  }
  // Read `late` before late_by_ns, because the process writes them in the opposite order.
  const std::uint64_t late = slot.late.load(std::memory_order_acquire);
  if (std::exchange(member.seen_late, late) == late) return;
  if (member.model.miss != model::Miss::error || !member.in_tables()) return;
  if (member.state() == State::start) apply(member, Event::run);  // the module's first body was late
  const Nanoseconds by{slot.late_by_ns.load(std::memory_order_relaxed)};
  raise(member, ErrorType::deadline, "its body ended " + to_text(by) + " after its deadline");
}

void Supervisor::process_ended(Member& member, const ProcessEnd& end) {
  properties_->fail(member, "the program of module " + member.model.name + " has ended");
  platform_->wake(~0U);  // the process may have written samples without waking their readers
  std::string text = "the process " + end.text;
  if (!member.hung.empty()) text = "the process " + member.hung + " and was killed";
  if (const std::string words = member.program->last_line(); !words.empty())
    text += "; its last line was: " + words;

  if (member.state() == State::destruct) return;
  const bool to_end = member.command && member.command->begun && member.command->verb == Verb::destruct;
  if (phase_ == Phase::stopping || to_end) {
    take_from_tables(member);  // otherwise an executor could begin a last row with the module
    if (member.machine.accepts(Event::stop)) apply(member, Event::stop);
    apply(member, Event::destruct, end.text);
    return;
  }
  // A program has not finished its work if it ends before the cell runs or before it calls its init function.
  const bool finished =
      !end.signalled && end.code == 0 && phase_ == Phase::running && member.state() != State::idle;
  if (member.command && member.command->begun && member.command->verb == Verb::stop && !member.scheduled() &&
      member.state() == State::executing) {
    apply(member, Event::stop, end.text);
    return;
  }
  if (finished) {
    member.block.finished.store(1, std::memory_order_release);
    take_from_tables(member);
    member.up_to = State::idle;
    if (member.machine.accepts(Event::stop)) apply(member, Event::stop);
    apply(member, Event::destruct, kFinished);
    return;
  }
  switch (member.state()) {
    case State::idle:
      lose(member, text + "; it had not called " + init_function(member), ErrorType::crash);
      break;
    case State::recover:
      member.started_again = false;
      not_recovered(member, text);
      break;
    case State::initialize:
    case State::start:
    case State::executing:
      take_from_tables(member);
      if (!member.hung.empty()) {
        raise(member, ErrorType::hang, text,
              from_ns(member.slot->release_ns.load(std::memory_order_relaxed)));
      } else {
        raise(member, ErrorType::crash, text, std::nullopt,
              end.no_core.empty() ? "" : "; no core dump: " + end.no_core, end.core);
      }
      break;
    case State::destruct:
      break;
  }
}

// Ends a program: first by the flag in its slot that ends its wait, then by SIGTERM, then by SIGKILL.
void Supervisor::end_process(Member& member, Instant now) {
  if (!member.runs()) return;
  if (member.told_to_end == Instant{}) {
    member.told_to_end = now;
    if (member.slot != nullptr) {
      member.slot->end.store(1, std::memory_order_seq_cst);
      platform_->wake(~0U);
    } else {
      member.end_signals = 1;
      member.program->terminate();
    }
    return;
  }
  const Nanoseconds waited = lasted(member.told_to_end);
  if (member.end_signals < 1 && waited > kProcessEndLimit) {
    member.end_signals = 1;
    log(member, "does not return to its wait function; sending SIGTERM");
    member.program->terminate();
  } else if (member.end_signals < 2 && waited > 2 * kProcessEndLimit) {
    member.end_signals = 2;
    log(member, "does not end on SIGTERM; sending SIGKILL");
    member.program->kill();
  }
}

}  // namespace takt::supervision
