#include <takt/model/alarm.hpp>

#include <algorithm>
#include <charconv>
#include <tuple>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>

namespace takt::model {

namespace {

using Json = nlohmann::ordered_json;

/// What must end for the alarm to return to normal.
enum class Condition {
  event,   ///< nothing: the cause is a single event
  module,  ///< the module is in RECOVER or given up
  input,   ///< an input has no fresh value
  other,   ///< another device is lost
  device,  ///< this device has failed
};

/// Returns the condition of an event that raises an alarm; none for any other event. An unsuccessful recovery
/// raises none, because the error before it did. A log line raises none: a module that needs somebody fails.
std::optional<Condition> condition_of(FaultKind kind, const std::string& module) {
  if (kind == FaultKind::stale_input) return Condition::input;
  if (severity_of(kind) != Severity::error || kind == FaultKind::not_recovered || is_log_line(kind))
    return std::nullopt;
  if (kind == FaultKind::device_lost) return Condition::other;
  if (kind == FaultKind::device_failed) return Condition::device;
  const bool is_failure = kind == FaultKind::error || kind == FaultKind::given_up;
  return is_failure && !module.empty() ? Condition::module : Condition::event;
}

Condition condition_of(const Alarm& alarm) {
  return condition_of(alarm.kind, alarm.module).value_or(Condition::event);
}

/// Returns the part of `text` between two texts; empty if they are not there.
std::string_view between(std::string_view text, std::string_view before, std::string_view after) {
  const std::size_t begin = text.find(before);
  if (begin == std::string_view::npos) return {};
  text.remove_prefix(begin + before.size());
  return text.substr(0, text.find(after));
}

/// Returns the name of the input or of the lost device of which a cause speaks.
std::string_view subject_of(Condition condition, std::string_view cause) {
  if (condition == Condition::input) return between(cause, "input '", "'");
  if (condition == Condition::other) return between(cause, "device ", " ");
  return {};
}

/// Returns true if an event of this condition belongs to the alarm.
bool belongs(const Alarm& alarm, Condition condition, const Fault& fault) {
  return alarm.module == fault.module && condition_of(alarm) == condition &&
         (condition != Condition::event || alarm.kind == fault.kind) &&
         subject_of(condition, alarm.cause) == subject_of(condition, fault.cause);
}

struct Acknowledged {
  std::uint64_t number = 0;
  std::string by;
  std::string note;
};
constexpr std::string_view kBefore = "alarm ";
constexpr std::string_view kBy = " acknowledged by ";
constexpr std::string_view kNote = ": ";

/// Reads what acknowledgement_text() has written.
std::optional<Acknowledged> acknowledged_from(std::string_view cause) {
  Acknowledged read;
  const std::string_view number = between(cause, kBefore, " ");
  if (std::from_chars(number.data(), number.data() + number.size(), read.number).ec != std::errc{})
    return std::nullopt;
  read.by = between(cause, kBy, kNote);
  read.note = between(cause.substr(std::min(cause.size(), cause.find(kBy))), kNote, "\n");
  return read;
}

Json null_if_empty(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

std::string text_in(const Json& value, const char* name) {
  const Json& member = value.at(name);
  return member.is_null() ? std::string{} : member.get<std::string>();
}

std::uint64_t number_in(const Json& value, const char* name) {
  const auto number = whole_number(value.at(name));
  if (!number) throw Json::other_error::create(500, "not a number", nullptr);
  return *number;
}

std::int64_t time_in(const Json& value, const char* name) {
  return static_cast<std::int64_t>(std::min<std::uint64_t>(number_in(value, name), INT64_MAX));
}

Alarm alarm_from(const Json& value) {
  const auto kind = fault_kind(text_in(value, "kind"));
  if (!kind) throw Json::other_error::create(500, "unknown kind", nullptr);
  Alarm alarm{.number = number_in(value, "number"),
              .since_ns = time_in(value, "since_ns"),
              .last_ns = time_in(value, "last_ns"),
              .device = text_in(value, "device"),
              .module = text_in(value, "module"),
              .kind = *kind,
              .error = text_in(value, "error"),
              .cause = text_in(value, "cause"),
              .count = number_in(value, "count"),
              .active = value.at("active").get<bool>()};
  if (const Json& said = value.at("acknowledged"); !said.is_null())
    alarm.acknowledged = {text_in(said, "by"), text_in(said, "note"), time_in(said, "time_ns")};
  return alarm;
}

}  // namespace

const char* state_of(const Alarm& alarm) noexcept {
  if (alarm.acknowledged) return "acknowledged";
  return alarm.active ? "unacknowledged" : "unacknowledged, returned to normal";
}

bool is_worse(const Alarm& a, const Alarm& b) noexcept {
  const auto rank = [](const Alarm& alarm) {
    return std::tuple{alarm.acknowledged.has_value(), !alarm.active,
                      severity_of(alarm.kind) != Severity::error, -alarm.last_ns};
  };
  return rank(a) < rank(b);
}

Json to_json(const Alarm& alarm) {
  Json acknowledged = nullptr;
  if (const auto& said = alarm.acknowledged)
    acknowledged = {{"by", said->by}, {"note", null_if_empty(said->note)}, {"time_ns", said->time_ns}};
  return {{"device", alarm.device},
          {"module", null_if_empty(alarm.module)},
          {"kind", to_text(alarm.kind)},
          {"severity", to_text(severity_of(alarm.kind))},
          {"error", null_if_empty(alarm.error)},
          {"cause", alarm.cause},
          {"count", alarm.count},
          {"number", alarm.number},
          {"since_ns", alarm.since_ns},
          {"last_ns", alarm.last_ns},
          {"state", state_of(alarm)},
          {"active", alarm.active},
          {"acknowledged", std::move(acknowledged)}};
}

Json to_json(const std::vector<Alarm>& alarms) {
  Json list = Json::array();
  for (const Alarm& alarm : alarms) list.push_back(to_json(alarm));
  return list;
}

std::optional<std::vector<Alarm>> alarms_from(const Json& value) {
  if (!value.is_array()) return std::nullopt;
  try {
    std::vector<Alarm> alarms;
    for (const Json& each : value) alarms.push_back(alarm_from(each));
    return alarms;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

void Alarms::take(const Fault& fault) {
  if (fault.kind == FaultKind::acknowledged) {
    const auto read = acknowledged_from(fault.cause);
    const auto found = std::ranges::find_if(alarms_, [&](const Alarm& each) {
      return read && each.number == read->number && !each.acknowledged;
    });
    if (found == alarms_.end()) return;
    found->acknowledged = {read->by, read->note, fault.time_ns};
    if (!found->active) alarms_.erase(found);
    ++changes_;
    return;
  }
  const auto end = [this](const auto& ends) {
    for (Alarm& alarm : alarms_) {
      if (!alarm.active || !ends(alarm)) continue;
      alarm.active = false;
      ++changes_;
    }
    std::erase_if(alarms_, [](const Alarm& alarm) { return alarm.acknowledged && !alarm.active; });
  };
  switch (fault.kind) {
    case FaultKind::fresh_input:
      return end([&](const Alarm& alarm) { return belongs(alarm, Condition::input, fault); });
    case FaultKind::device_back:
      return end([&](const Alarm& alarm) { return belongs(alarm, Condition::other, fault); });
    case FaultKind::undeployed:
      return end([](const Alarm& alarm) {
        return condition_of(alarm) == Condition::input || condition_of(alarm) == Condition::other;
      });
    case FaultKind::node_start:
    case FaultKind::node_restart:
      end([](const Alarm& alarm) { return condition_of(alarm) != Condition::other; });
      break;  // a restart raises an alarm itself
    default:
      break;
  }
  const auto condition = condition_of(fault.kind, fault.module);
  if (!condition) return;
  ++changes_;
  Alarm raised{.number = fault.sequence,
               .since_ns = fault.time_ns,
               .last_ns = fault.time_ns,
               .device = fault.device,
               .module = fault.module,
               .kind = fault.kind,
               .error = fault.error,
               .cause = fault.cause,
               .count = fault.count,
               .active = *condition != Condition::event};
  const auto known =
      std::ranges::find_if(alarms_, [&](const Alarm& each) { return belongs(each, *condition, fault); });
  if (known != alarms_.end()) {
    if (!known->acknowledged) {
      raised.since_ns = known->since_ns;
      raised.count += known->count;
      // The operator has seen an alarm of this kind, and can acknowledge it by this number. Another kind is
      // news.
      if (raised.kind == known->kind) raised.number = known->number;
    }
    alarms_.erase(known);
  } else if (alarms_.size() == kMost) {
    alarms_.erase(std::ranges::min_element(alarms_, {}, [](const Alarm& alarm) {
      return std::pair{!alarm.acknowledged.has_value(), alarm.number};
    }));
  }
  alarms_.push_back(std::move(raised));
}

void Alarms::update(const std::function<bool(const std::string&)>& is_faulty,
                    const std::function<bool(const std::string&)>& is_in_cell) {
  for (Alarm& alarm : alarms_) {
    const Condition condition = condition_of(alarm);
    bool active = alarm.active;
    if (condition == Condition::module || condition == Condition::device) active = is_faulty(alarm.module);
    if (condition == Condition::other)
      active = active && is_in_cell(std::string{subject_of(condition, alarm.cause)});
    if (active != alarm.active) ++changes_;
    alarm.active = active;
  }
  std::erase_if(alarms_, [](const Alarm& alarm) { return alarm.acknowledged && !alarm.active; });
}

std::vector<Alarm> Alarms::unacknowledged(const std::string& module, std::uint64_t number) const {
  std::vector<Alarm> found;
  for (const Alarm& alarm : alarms_) {
    if (!alarm.acknowledged && (number == 0 || alarm.number == number) &&
        (module.empty() || alarm.module == module))
      found.push_back(alarm);
  }
  return found;
}

std::vector<std::uint64_t> Alarms::needed() const {
  std::vector<std::uint64_t> numbers;
  for (const Alarm& alarm : unacknowledged()) numbers.push_back(alarm.number);
  return numbers;
}

bool Alarms::is_lost(const std::string& device) const {
  return std::ranges::any_of(alarms_, [&device](const Alarm& alarm) {
    return alarm.active && condition_of(alarm) == Condition::other &&
           subject_of(Condition::other, alarm.cause) == device;
  });
}

Json to_json(const Acknowledge& acknowledge) {
  Json value{{"note", acknowledge.note}};
  if (acknowledge.alarm != 0) value["alarm"] = acknowledge.alarm;
  return value;
}

Result<Acknowledge> acknowledge_from(std::string_view text) {
  const auto invalid = [](const std::string& what) {
    return fail("the acknowledgement is not valid: " + what);
  };
  const Json value = parse_json(text);
  if (!value.is_object()) return invalid("it is not a JSON object");
  Acknowledge read;
  for (const auto& [name, member] : value.items()) {
    if (name == "note" && member.is_string()) {
      read.note = member.get<std::string>();
    } else if (const auto number = whole_number(member); name == "alarm" && number) {
      read.alarm = *number;
    } else {
      return invalid("its member " + in_quotes(name) + " is unknown, or has a wrong type");
    }
  }
  if (read.note.size() > Acknowledge::kLongestNote)
    return invalid("the note has " + std::to_string(read.note.size()) + " bytes, but may have at most " +
                   std::to_string(Acknowledge::kLongestNote));
  return read;
}

std::string acknowledgement_text(const Alarm& alarm, const std::string& by, const std::string& note) {
  std::string text{kBefore};
  text += std::to_string(alarm.number) + " (" + to_text(alarm.kind) + ")";
  text.append(kBy).append(by);
  if (!note.empty()) text.append(kNote).append(on_one_line(note));
  return text;
}

}  // namespace takt::model
