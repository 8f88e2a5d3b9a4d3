// What an operator asks of a module while the device runs: each a step of the lifecycle's table, taken here
// because hooks must be waited for, and rows.
#include <array>
#include <utility>

#include <takt/node/supervisor.hpp>
#include <takt/os/clock.hpp>
#include "limits.hpp"

namespace takt::node {

using channel::Doing;
using lifecycle::Event;
using lifecycle::State;

namespace {

// `start` is two events: the hook, and into the tables.
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

std::string refusal(Verb verb, State state) {
  std::string states;
  for (const State each : lifecycle::kStates) {
    if (!allowed(verb, each)) continue;
    states += (states.empty() ? "" : " or ") + std::string{lifecycle::to_text(each)};
  }
  return std::string{name_of(verb)} + " is refused in state " + lifecycle::to_text(state) +
         "; it is allowed in " + states;
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

void Supervisor::order(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) {
  Member& member = *members_.at(module);
  const auto refuse = [&](const std::string& text) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = text});
  };
  if (phase_ != Phase::running) return refuse("the device does not run");
  if (member.order) return refuse(std::string{name_of(member.order->verb)} + " is still under way");
  if (member.swap) return refuse("a swap is still under way");
  if (!allowed(verb, member.state())) return refuse(refusal(verb, member.state()));
  log(member, std::string{name_of(verb)} + " was ordered");
  member.order = Order{.verb = verb, .done = std::move(done), .since = os::now()};
  order_step(member, os::now());
}

void Supervisor::end_order(Member& member, ReplyCode code, const std::string& text) {
  const Order order = std::move(*member.order);
  member.order.reset();
  if (code != REPLY_OK) log(member, std::string{name_of(order.verb)} + " failed: " + text);
  order.done({.code = code, .state = member.state(), .text = text});
}

// What was ordered stays wanted: an error on the way there is mended as any other.
std::string Supervisor::what_follows(const Member& member) {
  if (member.state() != State::recover) return {};
  return std::string{"; its recovery goes on, to "} +
         lifecycle::to_text(member.wanted() ? State::executing : State::start);
}

// The state is as the table wants it and no hook is being called.
void Supervisor::begin_order(Member& member) {
  Order& order = *member.order;
  order.begun = true;
  switch (order.verb) {
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
        if (member.state() == State::start)
          put_in_tables(member);
        else if (member.is_thread())
          ask(member, Doing::start);
        break;  // else watch_process() sees when the program is ready
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
      order.attempts = member.recovery.attempts();
      member.recovery.hurry();
      break;
    case Verb::reset:
      member.up_to = State::idle;
      member.lost = member.failed = member.stale = member.started_again = member.reload = false;
      member.why.clear();
      member.recovery = lifecycle::Recovery{
          {.attempts = member.model.recovery.attempts, .backoff = member.model.recovery.backoff}};
      member.block.error.store(0, std::memory_order_relaxed);
      saved_of(member).clear();  // it is to begin anew
      if (Hosted& host = host_of(member); member.scheduled() && !host.link.running()) {  // it was given up
        host.restarts.clear();
        note(member, model::FaultKind::host_restart, "it was given up, and this module is reset");
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

void Supervisor::order_step(Member& member, Instant now) {
  Order& order = *member.order;
  if (now - order.since > kCommandLimit) {
    return end_order(member, REPLY_FAILED,
                     "it did not come about within " + to_text(kCommandLimit) + " and goes on by itself");
  }
  if (!order.begun) {
    if (member.pending) return;
    if (!allowed(order.verb, member.state()))
      return end_order(member, REPLY_REFUSED, refusal(order.verb, member.state()));
    if (order.verb == Verb::recover && member.stale && has_stale_input(member, now))
      return end_order(member, REPLY_REFUSED, "it waits for its input: " + member.why);
    begin_order(member);
    if (!member.order) return;
  }
  const State state = member.state();
  const auto failed = [&] {
    end_order(member, REPLY_FAILED,
              "it went to " + std::string{lifecycle::to_text(state)} +
                  (member.why.empty() ? "" : ": " + member.why) + what_follows(member));
  };
  switch (order.verb) {
    case Verb::initialize:
      if (state == State::initialize) return end_order(member, REPLY_OK);
      if (state != State::idle) return failed();
      return;
    case Verb::start:
      if (state == State::executing) return end_order(member, REPLY_OK);
      if (state == State::recover || state == State::destruct) return failed();
      if (state == State::start && member.in_tables() && now - member.put_in_at > kNamedWithin)
        return end_order(member, REPLY_OK, "it runs with the next row that names it");
      return;
    case Verb::stop:
      if (state == State::executing) {
        if (member.is_process() && !member.scheduled()) end_process(member, now);
        if (is_out(member)) apply(member, Event::stop);
      } else if (state != State::start) {
        return failed();
      }
      if (member.state() == State::start) end_order(member, REPLY_OK);
      return;
    case Verb::recover:
      if (state == State::start || state == State::executing) return end_order(member, REPLY_OK);
      if (state == State::destruct) return failed();
      if (member.recovery.attempts() > order.attempts && !member.pending && !member.started_again)
        end_order(member, REPLY_FAILED, "it could not recover: " + member.why);
      return;
    case Verb::reset:
      if (state == State::idle && !member.pending) return end_order(member, REPLY_OK);
      if (state == State::destruct && !member.pending) end_order(member, REPLY_FAILED, member.why);
      return;
    case Verb::destruct:
      if (state == State::destruct && !member.child.running()) return end_order(member, REPLY_OK);
      if (member.is_process() || is_out(member)) destruct(member, now);
      return;
  }
}

}  // namespace takt::node
