// What an operator may ask of a module while the device runs. An order begins here, if the lifecycle's table
// allows it, and is answered when the module is where it was to go, or has failed to.
#include <utility>

#include <takt/node/limits.hpp>
#include <takt/node/supervisor.hpp>
#include <takt/os/clock.hpp>

namespace takt::node {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

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

namespace {

/// Why an order makes no sense in this state, and what would; null where it does.
const char* against(Verb verb, State state) noexcept {
  switch (verb) {
    case Verb::initialize:
      return state == State::idle ? nullptr
                                  : "it initialises a module in IDLE; reset brings one from DESTRUCT there";
    case Verb::start:
      return state == State::initialize || state == State::start
                 ? nullptr
                 : "it starts a module in INITIALIZE or START; initialize comes before it, recover is for "
                   "RECOVER, reset for "
                   "DESTRUCT";
    case Verb::stop:
      return state == State::executing || state == State::start ? nullptr
                                                                : "it stops a module that is EXECUTING";
    case Verb::recover:
      return state == State::recover ? nullptr : "it is for a module in RECOVER; reset is for DESTRUCT";
    case Verb::reset:
      return state == State::destruct ? nullptr : "it is for a module in DESTRUCT; destruct comes before it";
    case Verb::destruct:
      return state == State::destruct ? "it is there already" : nullptr;
  }
  return nullptr;
}

}  // namespace

void Supervisor::order(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) {
  Member& member = *members_.at(module);
  const std::string what =
      std::string{name_of(verb)} + " is refused in " + lifecycle::to_text(member.state()) + ": ";
  const auto refuse = [&](const std::string& why) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = what + why});
  };
  if (phase_ != Phase::running) return refuse("the device does not run");
  if (member.ordered)
    return refuse(std::string{name_of(member.ordered->verb)} + " is still being carried out");
  if (const char* why = against(verb, member.state()); why != nullptr) return refuse(why);
  if (verb == Verb::stop && member.state() == State::start && !member.in_tables())
    return refuse("it is stopped already");
  const bool plain = member.is_process() && !member.scheduled();
  if (verb == Verb::stop && plain) return refuse("a plain program goes on by itself; destruct ends it");
  if (member.is_thread() && !host_.running()) return refuse("its host is being started again");
  if (member.pending && verb != Verb::destruct)
    return refuse(std::string{channel::to_text(*member.pending)} + " is being called");

  member.ordered = Ordered{verb, os::now(), std::move(done), member.recovery.attempts()};
  switch (verb) {
    case Verb::initialize:
      if (member.is_thread()) {
        ask(member, Doing::initialize);
      } else if (plain) {
        apply(member, Event::initialize);
      } else if (auto spawned = spawn(member); !spawned) {
        finish(member, REPLY_FAILED, in_words(spawned.problems()));
      }
      break;
    case Verb::start:
      member.wanted = true;
      if (member.state() == State::initialize && member.is_thread()) {
        ask(member, Doing::start);
      } else if (member.state() == State::start && !plain) {
        put_in_tables(member);
      } else if (plain) {
        if (member.state() == State::initialize) apply(member, Event::start);
        if (auto spawned = spawn(member); !spawned) {
          finish(member, REPLY_FAILED, in_words(spawned.problems()));
        } else {
          apply(member, Event::run);
        }
      }
      break;
    case Verb::stop:
      member.wanted = false;
      take_from_tables(member);
      break;
    case Verb::recover:
      member.recovery.hurry();
      break;
    case Verb::reset:
      member.lost = member.failed = member.stale = member.started_again = false;
      member.wanted = false;
      member.why.clear();
      member.block.error.store(0);
      member.told_to_end = {};
      member.end_signals = 0;
      member.recovery = lifecycle::Recovery{
          {.attempts = member.model.recovery.attempts, .backoff = member.model.recovery.backoff}};
      apply(member, Event::reset);
      if (member.is_thread()) ask(member, Doing::load);
      break;
    case Verb::destruct:
      member.wanted = false;
      take_from_tables(member);
      break;
  }
  order_step(member, os::now());
}

// Looks how far the order has come.
void Supervisor::order_step(Member& member, Instant now) {
  if (!member.ordered) return;
  const State state = member.state();
  switch (member.ordered->verb) {
    case Verb::initialize:
      if (state == State::initialize) return finish(member, REPLY_OK);
      break;
    case Verb::start:
      if (state == State::executing) return finish(member, REPLY_OK);
      if (state == State::initialize && member.is_process() && member.scheduled() &&
          member.seat->phase.load(std::memory_order_acquire) == channel::SeatPhase::ready) {
        process_ready(member);
        apply(member, Event::start);
        put_in_tables(member);
      }
      // A sporadic module is EXECUTING once it is released.
      if (state == State::start && member.in_tables() && now - member.ordered->since > kNamedWithin)
        return finish(member, REPLY_OK);
      break;
    case Verb::stop:
      if (!is_out(member)) break;
      if (state == State::executing) apply(member, Event::stop);
      return finish(member, REPLY_OK);
    case Verb::recover:
      if (state == State::start || state == State::executing) return finish(member, REPLY_OK);
      if (member.recovery.attempts() > member.ordered->attempts && !member.pending && !member.started_again)
        return finish(member, REPLY_FAILED, member.why);
      break;
    case Verb::reset:
      if (member.lost) return finish(member, REPLY_FAILED, member.why);
      if (state == State::idle && !member.pending) return finish(member, REPLY_OK);
      break;
    case Verb::destruct:
      if (state == State::destruct) return finish(member, REPLY_OK);
      if (member.is_thread() ? is_out(member) : true) destruct(member, now);
      break;
  }
  if (state == State::destruct && member.ordered->verb != Verb::reset)
    return finish(member, REPLY_FAILED, member.why);
  if (state == State::recover && member.ordered->verb == Verb::start)
    return finish(member, REPLY_FAILED, member.why);
  if (now - member.ordered->since > kOrderLimit) {
    finish(member, REPLY_FAILED,
           std::string{name_of(member.ordered->verb)} + " did not come about within " + to_text(kOrderLimit));
  }
}

void Supervisor::finish(Member& member, ReplyCode code, const std::string& text) {
  if (!member.ordered) return;
  const auto done = std::move(member.ordered->done);
  member.ordered.reset();
  done({.code = code, .state = member.state(), .text = text});
}

}  // namespace takt::node
