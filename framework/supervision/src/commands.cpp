// The commands of an operator to modules of a running device. Each command takes one or more steps of the
// lifecycle's table. A command takes time, because hooks and rows must complete between these steps.
#include <array>
#include <utility>

#include <takt/supervision/supervisor.hpp>
#include "fault_notes.hpp"
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

namespace {

// True if a command is allowed in a state. The command `start` causes two events: `start` (the hook) and
// `run` (the first run).
bool allowed(Verb verb, State state) {
  const auto takes = [state](Event event) {
    return lifecycle::next(state, event, State::executing).has_value();
  };
  switch (verb) {
    case Verb::initialize:
      return takes(Event::initialize);
    case Verb::start:
      return takes(Event::start) || takes(Event::run);
    case Verb::stop:
      return takes(Event::stop);
    case Verb::recover:
      return takes(Event::recover);
    case Verb::reset:
      return takes(Event::reset);
    case Verb::destruct:
      return takes(Event::destruct);
  }
  return false;
}

// Returns why a command is not allowed in a state, and which command is. `path` is DEVICE.MODULE.
std::string refusal(Verb verb, State state, const std::string& path) {
  std::string states;
  for (const State each : lifecycle::kStates) {
    if (!allowed(verb, each)) continue;
    states += (states.empty() ? "" : " or ") + std::string{lifecycle::to_text(each)};
  }
  std::string cure;
  if (verb == Verb::start && state == State::idle) cure = "; run takt initialize " + path + " first";
  if (state == State::destruct && verb != Verb::stop && verb != Verb::destruct)
    cure = "; run takt reset " + path + " first, or takt restart " + path;
  return std::string{name_of(verb)} + " is not allowed in state " + lifecycle::to_text(state) +
         "; it is allowed in " + states + cure;
}

}  // namespace

const char* name_of(Verb verb) noexcept {
  switch (verb) {
    case Verb::initialize:
      return "initialize";
    case Verb::start:
      return "start";
    case Verb::stop:
      return "stop";
    case Verb::recover:
      return "recover";
    case Verb::reset:
      return "reset";
    case Verb::destruct:
      return "destruct";
  }
  return "?";
}

void Supervisor::command(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) {
  Member& member = *members_.at(module);
  const auto refuse = [&](const std::string& text) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = text});
  };
  if (phase_ != Phase::running) return refuse("the device is not running");
  if (member.command) return refuse(std::string{name_of(member.command->verb)} + " is still in progress");
  if (member.swap) return refuse("a swap is still in progress");
  const std::string path = device().name + "." + member.model.name;
  if (!allowed(verb, member.state())) return refuse(refusal(verb, member.state(), path));
  log(member, std::string{"command: "} + name_of(verb));
  member.command = PendingCommand{.verb = verb, .done = std::move(done), .since = time()};
  step_command(member, time());
}

void Supervisor::end_command(Member& member, ReplyCode code, const std::string& text) {
  const PendingCommand command = std::move(*member.command);
  member.command.reset();
  if (code != REPLY_OK) log(member, std::string{name_of(command.verb)} + " failed: " + text);
  command.done({.code = code, .state = member.state(), .text = text});
}

// Names the state to which a recovery leads: the target state of the command during which the error occurred.
std::string Supervisor::what_follows(const Member& member) {
  if (member.state() != State::recover) return {};
  return std::string{"; its recovery continues, with target state "} +
         lifecycle::to_text(member.wanted() ? State::executing : State::start);
}

// Begins a command. The caller has checked that the state allows the command and that no hook is being
// called.
void Supervisor::begin_command(Member& member) {
  PendingCommand& command = *member.command;
  command.begun = true;
  switch (command.verb) {
    case Verb::initialize:
      member.up_to = State::initialize;
      if (member.is_thread()) {
        ask(member, Doing::initialize);
      } else if (!member.scheduled()) {
        apply(member, Event::initialize);
      } else if (auto spawned = spawn(member); !spawned) {
        lose(member, in_words(spawned.problems()));
      }
      break;
    case Verb::start:
      member.up_to = State::executing;
      if (member.is_thread() || member.scheduled()) {
        if (member.state() != State::start) {
          if (member.is_thread()) ask(member, Doing::start);
        } else if (!member.put_in) {
          put_in_tables(member);
        }
        break;  // a process module that is not in START yet is put in by check_process()
      }
      if (member.state() == State::initialize) apply(member, Event::start);
      if (auto spawned = spawn(member); !spawned)
        raise(member, ErrorType::crash, in_words(spawned.problems()));
      else
        apply(member, Event::run);
      break;
    case Verb::stop:
      member.up_to = State::start;
      take_from_tables(member);
      break;
    case Verb::recover:
      command.attempts = member.recovery.attempts();
      member.recovery.hurry();
      break;
    case Verb::reset:
      member.up_to = State::idle;
      member.lost = member.failed = member.stale = member.started_again = member.reload = false;
      member.why.clear();
      member.recovery = lifecycle::Recovery{
          {.attempts = member.model.recovery.attempts, .backoff = member.model.recovery.backoff}};
      member.block.error.store(0, std::memory_order_relaxed);
      member.block.finished.store(0, std::memory_order_relaxed);
      if (auto* const ring = member.log_ring()) ring->safe_stop.store(0, std::memory_order_relaxed);
      parts_.saved_of(member.index).clear();  // a reset module starts without its saved state
      platform_->forget(member.index);
      // If the module's host was given up, start it again. Only an executor's own host can be given up.
      if (Hosted& host = host_of(member); member.scheduled() && !host.process->running()) {
        host.restarts.clear();
        notes_->note(member, model::FaultKind::host_restart,
                     "the host had been given up, and an operator reset this module");
        restart_host(host);
      }
      if (member.is_thread())
        ask(member, Doing::load);
      else
        apply(member, Event::reset);
      break;
    case Verb::destruct:
      member.up_to = State::idle;
      take_from_tables(member);
      break;
  }
}

void Supervisor::step_command(Member& member, Instant now) {
  PendingCommand& command = *member.command;
  if (now - command.since > kCommandLimit) {
    return end_command(member, REPLY_FAILED,
                       "not completed within " + to_text(kCommandLimit) + "; it continues in the background");
  }
  if (!command.begun) {
    if (member.pending) return;
    if (!allowed(command.verb, member.state()))
      return end_command(member, REPLY_REFUSED,
                         refusal(command.verb, member.state(), device().name + "." + member.model.name));
    if (command.verb == Verb::recover && member.stale && has_stale_input(member, now))
      return end_command(member, REPLY_REFUSED, "it waits for its input: " + member.why);
    begin_command(member);
    if (!member.command) return;
  }
  const State state = member.state();
  const auto failed = [&] {
    end_command(member, REPLY_FAILED,
                "it went to " + std::string{lifecycle::to_text(state)} +
                    (member.why.empty() ? "" : ": " + member.why + (member.failed ? way_out(member) : "")) +
                    what_follows(member));
  };
  switch (command.verb) {
    case Verb::initialize:
      if (state == State::initialize) return end_command(member, REPLY_OK);
      if (state != State::idle) return failed();
      return;
    case Verb::start:
      if (state == State::executing) return end_command(member, REPLY_OK);
      if (member.has_finished()) return end_command(member, REPLY_OK, kFinished);
      if (state == State::recover || state == State::destruct) return failed();
      if (state == State::start && member.in_tables() && now - member.put_in_at > kNamedWithin &&
          (!member.scheduled() || rows_every(member) > kNamedWithin))
        return end_command(member, REPLY_OK, "it will run in the next row of the table that contains it");
      return;
    case Verb::stop:
      if (state == State::executing) {
        if (member.is_process() && !member.scheduled()) end_process(member, now);
        if (is_out(member)) apply(member, Event::stop);
      } else if (state != State::start) {
        return failed();
      }
      if (member.state() == State::start) end_command(member, REPLY_OK);
      return;
    case Verb::recover:
      if (state == State::start || state == State::executing) return end_command(member, REPLY_OK);
      if (state == State::destruct) return failed();
      if (member.recovery.attempts() > command.attempts && !member.pending && !member.started_again)
        end_command(member, REPLY_FAILED, "it could not recover: " + member.why);
      return;
    case Verb::reset:
      if (state == State::idle && !member.pending) {
        const auto forgotten = platform_->forgotten(member.index);
        // Wait until the state is deleted from the disk. Otherwise a restart of the node would restore it.
        if (!forgotten) return;
        if (forgotten->ok()) return end_command(member, REPLY_OK);
        return end_command(
            member, REPLY_FAILED,
            "the module is reset, but its saved state is still on disk: " + in_words(forgotten->problems()));
      }
      if (state == State::destruct && !member.pending) end_command(member, REPLY_FAILED, member.why);
      return;
    case Verb::destruct:
      if (state == State::destruct && !member.runs()) return end_command(member, REPLY_OK);
      if (member.is_process() || is_out(member)) destruct(member, now);
      return;
  }
}

}  // namespace takt::supervision
