#include "properties.hpp"

#include <algorithm>
#include <utility>

#include <takt/core/log_level.hpp>
#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
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

const Member* Properties::answered(const host::Answer& answer) {
  auto request = waiting_.extract(answer.request.id);
  if (request.empty()) return nullptr;
  const Waiting& waiting = request.mapped();
  const bool set = answer.request.what == host::Request::Do::set;
  waiting.done({.code = answer.ok ? REPLY_OK : REPLY_REFUSED,
                .state = waiting.member->state(),
                .text = answer.ok ? "" : answer.text,
                .value = answer.ok ? (set ? answer.request.value : answer.text) : ""});
  return set && answer.ok ? waiting.member : nullptr;
}

void Properties::fail(const Hosted& host, const std::string& why) {
  for (auto entry = waiting_.begin(); entry != waiting_.end();) {
    if (entry->second.host != &host) {
      ++entry;
      continue;
    }
    const Waiting waiting = std::move(entry->second);
    entry = waiting_.erase(entry);
    waiting.done({.code = REPLY_FAILED, .state = waiting.member->state(), .text = why});
  }
}

void Supervisor::get(std::uint32_t module, const std::string& property,
                     std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(module);
  if (property == kLogLevelProperty) return log_level(member, nullptr, done);
  if (member.is_thread()) {
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
  const Member& member = *members_.at(module);
  if (property == kLogLevelProperty) return log_level(member, &value, done);
  if (member.is_thread()) {
    ask_property({.what = host::Request::Do::set, .module = module, .property = property, .value = value},
                 std::move(done));
    return;
  }
  done({.code = REPLY_REFUSED,
        .state = member.state(),
        .text = "a process module gets its properties, except log-level, when it starts; change the "
                "descriptor and run takt deploy --update with it, which restarts device " +
                device().name});
}

void Supervisor::ask_property(host::Request request, std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(request.module);
  const bool sets = request.what == host::Request::Do::set;
  std::string why;
  if (member.lost || member.state() == State::destruct) {
    const std::string path = device().name + "." + member.model.name;
    why = path + " is in " + lifecycle::to_text(member.state()) + ", in which its properties cannot be " +
          (sets ? "set" : "read") + "; run takt reset " + path +
          (sets ? "" : " and takt initialize " + path) + " first";
  } else if (!sets && member.state() == State::idle) {
    why = member.model.name + " is in IDLE; its properties can be read once it is in INITIALIZE";
  } else if (member.reload) {
    why = "its host has crashed, and its component is not loaded again yet; try again when it is EXECUTING";
  } else if (member.swap && sets) {
    why = "a swap of " + member.model.name + " is still in progress; try again later";
  } else if (phase_ == Phase::stopping || phase_ == Phase::ended || !host_of(member).process->running()) {
    why = "the host of device " + device().name + " is not running";
  }
  if (!why.empty()) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = why});
    return;
  }
  properties_->ask(member, host_of(member), std::move(request), std::move(done));
}

void Supervisor::property_answered(const host::Answer& answer) {
  const Member* const member = properties_->answered(answer);
  if (member == nullptr) return;
  log(*member, answer.request.property + " = " + answer.request.value);
  // Keep the value, so that the module also has it after a restart of the host.
  model::give_property(parts_.cell.devices[parts_.device].modules[member->index], answer.request.property,
                       answer.request.value);
  members_[member->index]->set.insert(answer.request.property);
}

// Returns how to leave DESTRUCT if a value that an operator has set may keep the module there; empty if no
// property was set.
std::string Supervisor::way_out(const Member& member) const {
  if (member.set.empty()) return {};
  std::string names;
  for (const std::string& name : member.set) names += (names.empty() ? "" : ", ") + name;
  const std::string path = device().name + "." + member.model.name;
  return "; takt restart keeps what takt set has set: " + names + "; to change it, run takt reset " + path +
         ", takt set " + path + " " + (member.set.size() == 1 ? names : "PROPERTY") +
         " VALUE and takt restart " + path;
}

}  // namespace takt::supervision
