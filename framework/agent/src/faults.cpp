// Events that the agent adds to the fault record (start, end, commands, lost devices), the alarms to which
// they lead, and the answers to COMMAND_LOG, COMMAND_ALARMS and COMMAND_ACKNOWLEDGE.
#include <algorithm>
#include <cstdlib>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/span.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/question.hpp>
#include <takt/wire/words.hpp>
#include "deployment.hpp"

namespace takt::agent {

using json = nlohmann::ordered_json;
using model::FaultKind;

namespace {

/// Returns the text of a command for the fault record, such as "stop" or "set gain = 2".
std::string command_text(const Command& command) {
  if (command.kind() == COMMAND_PREPARE)
    return command.property() == command.deployment() ? "deployment" : "update";
  std::string text = takt::to_text(command.kind());
  if (command.kind() == COMMAND_SET)
    text += " " + command.property().to_string() + " = " + command.value().to_string();
  if (command.kind() == COMMAND_SWAP) text += " to " + command.value().to_string();
  if (command.kind() == COMMAND_FORCE || command.kind() == COMMAND_END_FORCE)
    text += " " + command.property().to_string();
  return text;
}

bool changes_something(CommandKind kind) {
  switch (kind) {
    case COMMAND_INITIALIZE:
    case COMMAND_START:
    case COMMAND_STOP:
    case COMMAND_RECOVER:
    case COMMAND_RESET:
    case COMMAND_DESTRUCT:
    case COMMAND_SET:
    case COMMAND_SWAP:
      return true;
    default:
      return false;  // deployments and updates record other events; all other commands are questions
  }
}

}  // namespace

void Agent::note_start() {
  const FaultMemory& record = *options_.record;
  const auto& events = record.events();
  if (!events.empty() && events.back().kind != FaultKind::node_end) {
    note({.kind = FaultKind::node_restart,
          .cause = "the previous node did not shut down cleanly; its last event is number " +
                   std::to_string(events.back().sequence)});
  } else {
    note({.kind = FaultKind::node_start, .cause = "process " + std::to_string(options_.process_id)});
  }
  for (const Problem& problem : record.problems())
    note({.kind = FaultKind::error, .cause = "the fault record: " + in_words({problem})});
}

void Agent::note_end() {
  filter_.flush();
  note({.kind = FaultKind::node_end, .cause = "clean shutdown"});
  options_.record->sync();
}

void Agent::note(model::Fault fault, const std::string& origin) {
  // fault.time_ns is 0 or, for a log line, a time on the monotonic clock. The module itself wrote this time,
  // so it may be any value.
  const std::int64_t now_ns = to_ns(options_.now());
  const Nanoseconds age = fault.time_ns == 0 ? Nanoseconds{0} : span(fault.time_ns, now_ns);
  // The two clocks are not read at the same instant. If each event used a new difference of the clocks, the
  // order of events that are close together would change.
  const std::int64_t difference_ns = options_.wall_ns() - now_ns;
  if (std::abs(difference_ns - wall_ahead_ns_) > 1'000'000) wall_ahead_ns_ = difference_ns;
  fault.time_ns = now_ns + wall_ahead_ns_ -
                  std::clamp<Nanoseconds>(age, Nanoseconds{0}, std::chrono::seconds{10}).count();
  fault.cell = deployment_ ? deployment_->cell.name : std::string{};
  if (fault.cell.empty()) fault.cell = wire::kNoCell;
  fault.device = options_.device;
  if (fault.kind == FaultKind::error && deployment_) {
    const std::string component = deployment_->component_of(fault.module);
    if (!component.empty()) fault.cause += " (" + component + ")";
  }
  fault.cause = on_one_line(fault.cause);
  filter_.put(std::move(fault), options_.now(), origin);
}

void Agent::note_answer(const Command& command, ReplyCode code, const std::string& text) {
  const std::string module = command.module_name().to_string();
  if (code == REPLY_OK) {
    if (!changes_something(command.kind())) return;
    std::string cause = command_text(command) + " was carried out";
    const std::string component = deployment_ ? deployment_->component_of(module) : "";
    if (command.kind() == COMMAND_SWAP && !component.empty()) cause += ": now " + component;
    note({.module = module, .kind = FaultKind::command, .cause = cause});
    return;
  }
  if (wire::is_question(command.kind())) return;
  if (command.kind() == COMMAND_CHANGE && code == REPLY_FAILED) return;  // the undone update is recorded
  const std::string what = command_text(command);
  const bool begins_with_it = text.starts_with(what + " ");  // as in "stop is not allowed in state START"
  note({.module = module,
        .kind = code == REPLY_FAILED ? FaultKind::failed_command : FaultKind::refused_command,
        .cause = begins_with_it ? text : what + ": " + text},
       client_of(command));
}

namespace {

bool is_in(const model::Cell& cell, const std::string& device) {
  return std::ranges::any_of(cell.devices, [&](const model::Device& each) { return each.name == device; });
}

}  // namespace

// Records when other devices of the running cell are lost or come back.
void Agent::check_devices() {
  if (!deployment_ || !deployment_->is_final() || deployment_->over) return;
  std::erase_if(devices_seen_, [this](const auto& seen) { return !is_in(deployment_->cell, seen.first); });
  for (const model::Device& device : deployment_->cell.devices) {
    if (device.name == options_.device) continue;
    const auto seen = others_.of_device(device.name);
    const bool alive = std::any_of(seen.begin(), seen.end(), [](const auto& s) { return s.alive; });
    const auto [at, added] = devices_seen_.try_emplace(device.name, alive);
    const bool returned =
        added && alive && alarms_.is_lost(device.name);  // it was lost before this node started
    if ((std::exchange(at->second, alive) == alive || added) && !returned) continue;
    const std::string rejection = options_.rejection_of(device.name);
    std::string cause = "device " + device.name +
                        (alive                ? " is back"
                         : !rejection.empty() ? " is lost: " + rejection
                         : seen.empty()       ? " has left"
                                              : " is lost: nothing arrives from its node");
    // This node may have been stopped itself, so that the leases of the others ended meanwhile.
    if (!alive && !seen.empty() && options_.now() - stood_still_until_ < kLease)
      cause += "; this node did not run for " + takt::to_text(stood_still_for_);
    log(cause);
    note({.kind = alive ? FaultKind::device_back : FaultKind::device_lost, .cause = cause}, device.name);
  }
}

void Agent::send_log(const wire::WholeCommand& command) {
  auto filter = model::filter_from(command.data);
  if (!filter) {
    answer(command.head, REPLY_REFUSED, in_words(filter.problems()));
    return;
  }
  const FaultMemory& record = *options_.record;
  json events = json::array();
  for (const model::Fault& fault : filter->of(record.events())) events.push_back(model::to_json(fault));
  std::int64_t newest_ns = 0;
  for (const model::Fault& fault : record.events()) newest_ns = std::max(newest_ns, fault.time_ns);
  json lost = json::array();
  for (const auto& [name, alive] : devices_seen_) {
    if (!alive) lost.push_back(name);
  }
  answer(command.head, REPLY_OK, "",
         model::json_text({{"file", record.file().empty() ? json(nullptr) : json(record.file())},
                           {"newest", record.events().empty() ? 0 : record.events().back().sequence},
                           {"newest_time_ns", newest_ns},
                           {"overwritten", record.overwritten()},
                           {"damaged", record.damaged()},
                           {"lost", lost},
                           {"events", events}}));
}

void Agent::send_alarms(const Command& command) {
  answer(command, REPLY_OK, "", model::json_text(model::to_json(alarms_.all())));
}

void Agent::acknowledge(const wire::WholeCommand& command) {
  const auto asked = model::acknowledge_from(command.data);
  if (!asked) return answer(command.head, REPLY_REFUSED, in_words(asked.problems()));
  const std::string module = command.head.module_name().to_string();
  const auto alarms = alarms_.unacknowledged(module, asked->alarm);
  if (alarms.empty()) {
    if (!module.empty() && deployment_ && !module_of(command.head)) return;
    return answer(command.head, REPLY_REFUSED,
                  (module.empty() ? "device " + options_.device + " and its modules have"
                                  : "module " + options_.device + "." + module + " has") +
                      " no unacknowledged alarm" +
                      (asked->alarm == 0 ? "" : " " + std::to_string(asked->alarm)) +
                      "; takt alarms lists all alarms");
  }
  for (const model::Alarm& alarm : alarms) {
    note({.module = alarm.module,
          .kind = FaultKind::acknowledged,
          .cause = model::acknowledgement_text(alarm, sender_of(command), asked->note)});
  }
  answer(command.head, REPLY_OK, "", model::json_text(model::to_json(alarms)));
}

void Agent::update_alarms(DeviceStatus& status) {
  const auto is_faulty = [this, &status](const std::string& module) {
    if (module.empty()) return status.health() == HEALTH_FAILED;
    if (!deployment_) return false;
    const auto& modules = deployment_->modules;
    const auto found = std::ranges::find_if(
        modules, [&module](const LifecycleStatus& each) { return each.name() == module; });
    return found != modules.end() && (found->state() == STATE_RECOVER || is_given_up(*found));
  };
  alarms_.update(is_faulty, [this](const std::string& device) {
    return !deployment_ || is_in(deployment_->cell, device);
  });
  if (alarms_.changes() != published_.alarm_changes()) options_.record->keep(alarms_.needed());
  status.unacknowledged_alarms(static_cast<std::uint32_t>(alarms_.unacknowledged().size()));
  status.alarm_changes(alarms_.changes());
}

}  // namespace takt::agent
