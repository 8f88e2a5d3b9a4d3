#include "properties.hpp"

#include <algorithm>
#include <utility>

#include <takt/core/log_level.hpp>
#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using lifecycle::State;

bool Properties::busy(const Member& member) const {
  return std::any_of(waiting_.begin(), waiting_.end(),
                     [&member](const auto& entry) { return entry.second.member == &member; });
}

void Properties::ask(const Member& member, const Hosted& host, host::Request request, Done done) {
  request.id = ++asked_;
  waiting_.emplace(request.id, Waiting{.member = &member, .host = &host, .done = std::move(done)});
  host.process->ask(request);
}

void Properties::ask(const Member& member, Instant limit, host::Request request, Done done) {
  request.id = ++asked_;
  waiting_.emplace(request.id, Waiting{.member = &member,
                                       .host = nullptr,
                                       .limit = limit,
                                       .sets = request.what == host::Request::Do::set,
                                       .done = std::move(done)});
  queues_[&member].requests.push_back(std::move(request));
}

std::optional<host::Answer> Properties::take_answer(const Member& member) {
  const auto found = queues_.find(&member);
  if (found == queues_.end()) return std::nullopt;
  Queue& queue = found->second;
  channel::ReleaseSlot& slot = *member.slot;
  if (!queue.sent) {
    const host::Request& next = queue.requests.front();
    slot.property_request.ask(next.what == host::Request::Do::set, next.property, next.value);
    member.program->wake_for_property();
    queue.sent = true;
  }
  if (!slot.property_answer.answers(slot.property_request)) return std::nullopt;
  host::Answer answer{.request = std::move(queue.requests.front()),
                      .ok = slot.property_answer.ok == 1,
                      .text = std::string{slot.property_answer.text.view()},
                      .warnings = {}};
  queue.requests.pop_front();
  queue.sent = false;
  if (queue.requests.empty()) queues_.erase(found);
  return answer;
}

void Properties::answered(const host::Answer& answer) {
  auto request = waiting_.extract(answer.request.id);
  if (request.empty()) return;  // a program has answered after the limit
  const Waiting& waiting = request.mapped();
  const bool set = answer.request.what == host::Request::Do::set;
  waiting.done({.code = answer.ok ? REPLY_OK : REPLY_REFUSED,
                .state = waiting.member->state(),
                .text = answer.ok ? "" : answer.text,
                .value = answer.ok ? (set ? answer.request.value : answer.text) : ""});
}

template <class Fails, class Why>
void Properties::fail_if(const Fails& fails, const Why& why) {
  for (auto entry = waiting_.begin(); entry != waiting_.end();) {
    if (!fails(entry->second)) {
      ++entry;
      continue;
    }
    const std::uint64_t id = entry->first;
    const Waiting waiting = std::move(entry->second);
    entry = waiting_.erase(entry);
    bool sent = waiting.host != nullptr;
    if (const auto found = queues_.find(waiting.member); found != queues_.end()) {
      Queue& queue = found->second;
      sent = queue.sent && queue.requests.front().id == id;
      if (!sent) std::erase_if(queue.requests, [id](const host::Request& one) { return one.id == id; });
      if (queue.requests.empty()) queues_.erase(found);
    }
    waiting.done({.code = REPLY_FAILED, .state = waiting.member->state(), .text = why(waiting, sent)});
  }
}

void Properties::fail(const Hosted& host, const std::string& why) {
  fail_if([&](const Waiting& waiting) { return waiting.host == &host; },
          [&](const Waiting&, bool) { return why; });
}

void Properties::fail(const Member& member, const std::string& why) {
  queues_.erase(&member);
  fail_if([&](const Waiting& waiting) { return waiting.host == nullptr && waiting.member == &member; },
          [&](const Waiting&, bool) { return why; });
}

void Properties::expire(Instant now) {
  fail_if([&](const Waiting& waiting) { return waiting.limit && now >= *waiting.limit; },
          [](const Waiting& waiting, bool sent) {
            return "the program of module " + waiting.member->model.name + " has not answered within " +
                   to_text(kPropertyLimit) + ": it is stopped, or gets no CPU time" +
                   (waiting.sets && sent ? "; the value takes effect if the program still answers" : "");
          });
}

namespace {

/// True if the module's program declares properties. Other programs can have any property, and get it as an
/// argument when they start.
bool program_declares(const Member& member) {
  return member.slot != nullptr && member.slot->property_answer.serves.load(std::memory_order_acquire) != 0;
}

}  // namespace

void Supervisor::get(std::uint32_t module, const std::string& property,
                     std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(module);
  if (property == kLogLevelProperty) return log_level(member, nullptr, done);
  if (member.is_thread() || program_declares(member)) {
    ask_property({.what = host::Request::Do::get, .module = module, .property = property}, std::move(done));
    return;
  }
  const auto given = model::given_property(member.model, property);
  done({.code = given ? REPLY_OK : REPLY_REFUSED,
        .state = member.state(),
        .text = given ? "" : in_words(given.problems()),
        .value = given ? *given : ""});
}

void Supervisor::set(std::uint32_t module, const std::string& property, const std::string& value,
                     std::function<void(const Outcome&)> done) {
  Member& member = *members_.at(module);
  if (property == kLogLevelProperty) return log_level(member, &value, done);
  if (member.is_process() && member.state() == State::idle) {
    // No program runs that could check the value. The next one gets the value as an argument, and checks it.
    keep_property(member, property, value);
    done({.code = REPLY_OK, .state = member.state(), .text = "", .value = value});
    return;
  }
  ask_property({.what = host::Request::Do::set, .module = module, .property = property, .value = value},
               std::move(done));
}

void Supervisor::ask_property(host::Request request, std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(request.module);
  const bool sets = request.what == host::Request::Do::set;
  const bool ending = phase_ == Phase::stopping || phase_ == Phase::ended;
  std::string why;
  if (member.lost || member.state() == State::destruct) {
    const std::string path = device().name + "." + member.model.name;
    why = path + " is in " + lifecycle::to_text(member.state()) + ", in which its properties cannot be " +
          (sets ? "set" : "read") + "; run takt reset " + path +
          (sets ? "" : " and takt initialize " + path) + " first";
  } else if (!sets && member.state() == State::idle) {
    why = member.model.name + " is in IDLE; its properties can be read once it is in INITIALIZE";
  } else if (member.is_process() && !member.scheduled()) {
    why =
        "a process module without releases gets its properties as arguments when it starts; change the "
        "descriptor and run takt deploy --update with it, which restarts device " +
        device().name;
  } else if (member.reload) {
    why = "its host has crashed, and its component is not loaded again yet; try again when it is EXECUTING";
  } else if (member.swap && sets) {
    why = "a swap of " + member.model.name + " is still in progress; try again later";
  } else if (member.is_thread() && (ending || !host_of(member).process->running())) {
    why = "the host of device " + device().name + " is not running";
  } else if (member.is_process() && (ending || !member.runs())) {
    why = "the program of module " + member.model.name + " is not running; try again when it is EXECUTING";
  } else if (member.is_process() &&
             member.slot->phase.load(std::memory_order_acquire) == channel::ReleaseSlotPhase::empty) {
    why = "its program is being started again; try again when it is EXECUTING";
  } else if (member.is_process() && !program_declares(member)) {
    why =
        "its program declares no properties: it gets them, except log-level, as arguments when it starts; "
        "change the descriptor and run takt deploy --update with it, which restarts device " +
        device().name;
  } else if (member.is_process() && (request.property.size() > channel::PropertyRequest::kMostName ||
                                     request.value.size() > channel::PropertyRequest::kMostValue)) {
    why = "the name of a property has at most " + std::to_string(channel::PropertyRequest::kMostName) +
          " bytes, and a value that is set at most " + std::to_string(channel::PropertyRequest::kMostValue);
  }
  if (!why.empty()) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = why});
    return;
  }
  if (member.is_process())
    properties_->ask(member, time() + kPropertyLimit, std::move(request), std::move(done));
  else
    properties_->ask(member, host_of(member), std::move(request), std::move(done));
}

void Supervisor::step_properties(Instant now) {
  for (const auto& member : members_) {
    if (member->slot == nullptr) continue;
    while (const auto answer = properties_->take_answer(*member)) property_answered(*answer);
  }
  properties_->expire(now);
}

void Supervisor::property_answered(const host::Answer& answer) {
  if (answer.ok && answer.request.what == host::Request::Do::set)
    keep_property(*members_.at(answer.request.module), answer.request.property, answer.request.value);
  properties_->answered(answer);
}

// Keeps the value, so that the module also has it after a restart of its host or its program.
void Supervisor::keep_property(Member& member, const std::string& property, const std::string& value) {
  log(member, property + " = " + value);
  model::give_property(parts_.cell.devices[parts_.device].modules[member.index], property, value);
  member.set.insert(property);
}

// Returns how to start a module again that was given up. Names the properties that an operator has set,
// because their values stay and may be the cause. Empty if the device does not run, because no command helps
// then.
std::string Supervisor::way_out(const Member& member) const {
  if (phase_ != Phase::running) return {};
  const std::string path = device().name + "." + member.model.name;
  std::string text = "; to start it again, run takt restart " + path;
  if (member.set.empty()) return text;
  std::string names;
  for (const std::string& name : member.set) names += (names.empty() ? "" : ", ") + name;
  return text + ", which keeps what takt set has set: " + names + "; to change it before, run takt reset " +
         path + " and takt set " + path + " " + (member.set.size() == 1 ? names : "PROPERTY") + " VALUE";
}

}  // namespace takt::supervision
