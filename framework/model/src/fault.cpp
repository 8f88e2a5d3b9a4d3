#include <takt/model/fault.hpp>

#include <algorithm>
#include <limits>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>

namespace takt::model {

namespace {

using Json = nlohmann::ordered_json;

struct KindWord {
  const char* word;
  Severity severity;
};
// The word and severity of each kind, indexed by FaultKind.
constexpr std::array<KindWord, kFaultKinds> kKinds{{
    {"error", Severity::error},
    {"recovered", Severity::note},
    {"not-recovered", Severity::error},
    {"given-up", Severity::error},
    {"overrun", Severity::warning},
    {"missed-rows", Severity::warning},
    {"stale-input", Severity::warning},
    {"fresh-input", Severity::note},
    {"connection-lost", Severity::warning},
    {"connection-back", Severity::note},
    {"device-lost", Severity::error},
    {"device-back", Severity::note},
    {"clocks-differ", Severity::warning},
    {"clocks-agree", Severity::note},
    {"host-restart", Severity::error},
    {"program-restart", Severity::warning},
    {"node-start", Severity::note},
    {"node-restart", Severity::error},
    {"node-end", Severity::note},
    {"device-failed", Severity::error},
    {"deployed", Severity::note},
    {"undeployed", Severity::note},
    {"command", Severity::note},
    {"refused-command", Severity::warning},
    {"failed-command", Severity::warning},
    {"refused-packet", Severity::warning},
    {"refused-authentication", Severity::warning},
    {"not-real-time", Severity::warning},
    {"dropped-samples", Severity::warning},
    {"log-error", Severity::error},
    {"log-warning", Severity::warning},
    {"log-info", Severity::note},
    {"log-debug", Severity::note},
    {"forced", Severity::warning},
    {"force-ended", Severity::note},
    {"acknowledged", Severity::note},
}};

const KindWord* kind_of(FaultKind kind) noexcept {
  const auto index = static_cast<std::size_t>(kind);
  return index < kKinds.size() ? &kKinds[index] : nullptr;
}

}  // namespace

const char* to_text(FaultKind kind) noexcept {
  const KindWord* found = kind_of(kind);
  return found == nullptr ? "?" : found->word;
}

std::vector<std::string_view> fault_words() {
  std::vector<std::string_view> words;
  for (const KindWord& kind : kKinds) words.emplace_back(kind.word);
  return words;
}

namespace {
/// Returns a list of all words. suggestion() would list only the first 20.
std::string all_words() {
  std::string list;
  for (const std::string_view word : fault_words()) list += (list.empty() ? "" : ", ") + std::string{word};
  return list;
}
}  // namespace

std::optional<FaultKind> fault_kind(std::string_view word) noexcept {
  const auto found =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const KindWord& k) { return k.word == word; });
  if (found == kKinds.end()) return std::nullopt;
  return static_cast<FaultKind>(found - kKinds.begin());
}

const char* to_text(Severity severity) noexcept {
  switch (severity) {
    case Severity::note:
      return "note";
    case Severity::warning:
      return "warning";
    case Severity::error:
      return "error";
  }
  return "?";
}

Severity severity_of(FaultKind kind) noexcept {
  const KindWord* found = kind_of(kind);
  return found == nullptr ? Severity::error : found->severity;
}

bool is_log_line(FaultKind kind) noexcept {
  return kind >= FaultKind::log_error && kind <= FaultKind::log_debug;
}

Json to_json(const Fault& fault) {
  const auto or_null = [](const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); };
  return {{"sequence", fault.sequence},
          {"time_ns", fault.time_ns},
          {"cell", fault.cell == "-" ? Json(nullptr) : or_null(fault.cell)},
          {"device", fault.device},
          {"module", or_null(fault.module)},
          {"kind", to_text(fault.kind)},
          {"severity", to_text(severity_of(fault.kind))},
          {"error", or_null(fault.error)},
          {"cause", fault.cause},
          {"attachment", or_null(fault.attachment)},
          {"count", fault.count},
          {"cycle", fault.cycle == 0 ? Json(nullptr) : Json(fault.cycle)}};
}

std::optional<Fault> fault_from(const Json& value) {
  const auto text = [&value](const char* name) {
    const Json& member = value.at(name);
    return member.is_null() ? std::string{} : member.get<std::string>();
  };
  try {
    const auto kind = fault_kind(text("kind"));
    if (!kind) return std::nullopt;
    Fault fault{.sequence = value.at("sequence"),
                .time_ns = value.at("time_ns"),
                .cell = text("cell"),
                .device = text("device"),
                .module = text("module"),
                .kind = *kind,
                .error = text("error"),
                .cause = text("cause"),
                .attachment = text("attachment"),
                .count = value.at("count"),
                .cycle = value.at("cycle").is_null() ? 0 : value.at("cycle").get<std::uint64_t>()};
    if (fault.cell.empty()) fault.cell = "-";
    return fault;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

bool FaultFilter::takes(const Fault& fault) const {
  return (device.empty() || fault.device == device) && (module.empty() || fault.module == module) &&
         (kinds.empty() || std::find(kinds.begin(), kinds.end(), fault.kind) != kinds.end()) &&
         fault.sequence > after && fault.time_ns >= since_ns;
}

std::vector<Fault> FaultFilter::of(const std::vector<Fault>& faults) const {
  std::vector<Fault> taken;
  for (const Fault& fault : faults) {
    if (takes(fault)) taken.push_back(fault);
  }
  if (last && taken.size() > *last)
    taken.erase(taken.begin(), taken.end() - static_cast<std::ptrdiff_t>(*last));
  return taken;
}

Json to_json(const FaultFilter& filter) {
  Json value = Json::object();
  if (!filter.module.empty()) value["module"] = filter.module;
  for (const FaultKind kind : filter.kinds) value["kinds"].push_back(to_text(kind));
  if (filter.after != 0) value["after"] = filter.after;
  if (filter.since_ns != 0) value["since_ns"] = filter.since_ns;
  if (filter.last) value["last"] = *filter.last;
  return value;
}

Result<FaultFilter> filter_from(std::string_view text) {
  FaultFilter filter;
  if (text.empty()) return filter;
  const Json value = parse_json(text);
  if (!value.is_object()) return fail("the filter is not a JSON object");
  try {
    for (const auto& [name, member] : value.items()) {
      if (name == "module") {
        filter.module = member.get<std::string>();
      } else if (name == "kinds") {
        for (const auto& word : member) {
          const auto kind = fault_kind(word.get<std::string>());
          if (!kind) {
            return fail("unknown event kind " + in_quotes(word.get<std::string>()),
                        suggestion(word.get<std::string>(), fault_words()));
          }
          // Keep each kind only once. Any participant may send this list, and each event is compared with
          // each kind in it.
          if (std::find(filter.kinds.begin(), filter.kinds.end(), *kind) == filter.kinds.end())
            filter.kinds.push_back(*kind);
        }
      } else if (name == "since_ns" && member.is_number_integer() && !member.is_number_unsigned()) {
        // A negative time is before 1970. Such a time is valid, because the clock of a machine may never have
        // been set.
        filter.since_ns = member.get<std::int64_t>();
      } else if (name == "after" || name == "since_ns" || name == "last") {
        const auto number = whole_number(member);
        if (!number || *number > std::numeric_limits<std::int64_t>::max())
          return fail("the filter cannot be read: " + name + " must be a whole number of at least 0");
        if (name == "after") filter.after = *number;
        if (name == "since_ns") filter.since_ns = static_cast<std::int64_t>(*number);
        if (name == "last") filter.last = *number;
      } else {
        return fail("unknown member " + in_quotes(name) + " in the filter",
                    suggestion(name, {"module", "kinds", "after", "since_ns", "last"}));
      }
    }
  } catch (const Json::exception& error) {
    return fail(std::string{"the filter cannot be read: "} + error.what());
  }
  return filter;
}

Result<std::vector<FaultKind>> kinds_from(std::string_view list) {
  std::vector<FaultKind> kinds;
  while (true) {
    const std::string_view word = list.substr(0, list.find(','));
    const auto kind = fault_kind(word);
    if (!kind) {
      return fail("unknown event kind " + in_quotes(word), nearest(word, fault_words()).empty()
                                                               ? "the event kinds are " + all_words()
                                                               : suggestion(word, fault_words()));
    }
    kinds.push_back(*kind);
    if (word.size() == list.size()) return kinds;
    list.remove_prefix(word.size() + 1);
  }
}

}  // namespace takt::model
