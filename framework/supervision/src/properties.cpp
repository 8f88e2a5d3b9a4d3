// Reads and sets properties of modules while the device runs; the host holds those of thread modules.
#include <utility>

#include <takt/supervision/supervisor.hpp>
#include "hosted.hpp"
#include "limits.hpp"
#include "member.hpp"

namespace takt::supervision {

using lifecycle::State;

void Supervisor::get(std::uint32_t module, const std::string& property,
                     std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(module);
  if (member.is_thread()) {
    ask_property({.what = host::Request::Do::get, .module = module, .property = property}, std::move(done));
    return;
  }
  // A program received its properties as arguments.
  const auto given = model::given_property(member.model, property);
  done({.code = given ? REPLY_OK : REPLY_REFUSED,
        .state = member.state(),
        .text = given ? "" : in_words(given.problems()),
        .value = given ? *given : ""});
}

void Supervisor::set(std::uint32_t module, const std::string& property, const std::string& value,
                     std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(module);
  if (member.is_thread()) {
    ask_property({.what = host::Request::Do::set, .module = module, .property = property, .value = value},
                 std::move(done));
    return;
  }
  done({.code = REPLY_REFUSED,
        .state = member.state(),
        .text = member.model.name +
                " is a program: it is given its properties when it starts; undeploy the cell, change the "
                "descriptor and deploy it again"});
}

void Supervisor::ask_property(host::Request request, std::function<void(const Outcome&)> done) {
  const Member& member = *members_.at(request.module);
  std::string why;
  if (member.lost || member.state() == State::idle || member.state() == State::destruct) {
    why = member.model.name + " is in " + lifecycle::to_text(member.state()) +
          "; its properties can be read and set once it is in INITIALIZE";
  } else if (member.swap && request.what == host::Request::Do::set) {
    why = "a swap of " + member.model.name + " is still in progress; try again later";
  } else if (phase_ == Phase::stopping || phase_ == Phase::ended || !host_of(member).process->running()) {
    why = "the host of device " + device().name + " is not running";
  }
  if (!why.empty()) {
    done({.code = REPLY_REFUSED, .state = member.state(), .text = why});
    return;
  }
  request.id = ++property_requests_made_;
  property_requests_.emplace(request.id, PropertyRequest{.module = request.module, .done = std::move(done)});
  host_of(member).process->ask(request);  // if the host has ended, host_ended() answers
}

void Supervisor::property_answered(const host::Answer& answer) {
  auto request = property_requests_.extract(answer.request.id);
  if (request.empty()) return;
  const Member& member = *members_.at(request.mapped().module);
  const bool asked = answer.request.what == host::Request::Do::get;
  if (!asked && answer.ok) {
    log(member, answer.request.property + " = " + answer.request.value);
    // Keep the value for a restart of the host, which may be another module's fault.
    model::give_property(parts_.cell.devices[parts_.device].modules[member.index], answer.request.property,
                         answer.request.value);
  }
  request.mapped().done({.code = answer.ok ? REPLY_OK : REPLY_REFUSED,
                         .state = member.state(),
                         .text = answer.ok ? "" : answer.text,
                         .value = answer.ok ? (asked ? answer.text : answer.request.value) : ""});
}

void Supervisor::fail_property_requests(const Hosted& host, const std::string& why) {
  for (auto entry = property_requests_.begin(); entry != property_requests_.end();) {
    const Member& member = *members_.at(entry->second.module);
    if (member.host != host.index) {
      ++entry;
      continue;
    }
    const PropertyRequest request = std::move(entry->second);
    entry = property_requests_.erase(entry);
    request.done({.code = REPLY_FAILED, .state = member.state(), .text = why});
  }
}

}  // namespace takt::supervision
