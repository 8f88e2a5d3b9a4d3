#include <takt/client/answer_data.hpp>

#include <exception>
#include <initializer_list>

#include <takt/model/json.hpp>

namespace takt::client {

using json = nlohmann::ordered_json;

namespace {

/// An exception that read_answer() catches, for a member of the wrong type.
[[noreturn]] void reject() { throw json::other_error::create(500, "unexpected value", nullptr); }

const json& array_in(const json& object, const char* name) {
  const json& list = object.at(name);
  if (!list.is_array()) reject();
  return list;
}

void check_texts(const json& object, std::initializer_list<const char*> names) {
  for (const char* name : names) static_cast<void>(object.at(name).get_ref<const std::string&>());
}

void check_counts(const json& object, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (!model::whole_number(object.at(name))) reject();
  }
}

void check_times(const json& object, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (!object.at(name).is_number()) reject();
  }
}

/// Checks members that may be missing.
void check_optional_texts(const json& object, std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (object.contains(name)) check_texts(object, {name});
  }
}

void check_distribution(const json& of) { check_times(of, {"mean", "min", "p50", "p99", "p999", "max"}); }

void check_module(const json& module) {
  check_texts(module, {"name", "type", "operation", "state"});
  check_optional_texts(module, {"text"});
  check_counts(module, {"cycles", "overruns", "errors"});
  check_distribution(module.at("jitter_us"));
  check_distribution(module.at("run_us"));
  for (const char* flag : {"given_up", "safe_stop", "stopped"}) static_cast<void>(module.value(flag, false));
  if (module.contains("hash")) check_texts(module, {"file", "version", "hash"});
  if (!module.contains("ports")) return;
  for (const json& port : array_in(module, "ports")) {
    check_texts(port, {"name", "direction"});
    check_counts(port, {"connections", "matched", "samples", "lost", "dropped", "late"});
    if (!port.at("age_us").is_null()) check_times(port, {"age_us"});
    static_cast<void>(port.value("safe", false));
    if (!port.at("incompatible").is_null()) check_texts(port, {"incompatible"});
    for (const char* flag : {"losing", "dropping"}) static_cast<void>(port.value(flag, false));
    check_optional_texts(port, {"rating", "reason"});
  }
}

void check_violation(const json& violation) {
  check_texts(violation, {violation.contains("executor") ? "executor" : "module", "hook", "kind", "what"});
  check_counts(violation, {"count"});
  for (const json& call : array_in(violation, "backtrace"))
    static_cast<void>(call.get_ref<const std::string&>());
}

}  // namespace

Result<void> read_answer(const std::string& device, const std::string& data,
                         const std::function<void(const json&)>& read) {
  try {
    read(model::parse_json(data));
  } catch (const std::exception&) {
    return Problem{"device " + device, "its answer cannot be read",
                   "check that it runs the same version of Takt as this program"};
  }
  return {};
}

json checked_report(const json& report) {
  check_texts(report, {"name"});
  check_optional_texts(report, {"state", "text", "conflict"});
  for (const char* flag : {"alive", "real_time"}) static_cast<void>(report.at(flag).get<bool>());
  for (const json& executor : array_in(report, "executors")) {
    check_texts(executor, {"name"});
    check_counts(executor, {"cycles", "missed"});
    static_cast<void>(executor.value("margin_us", 0.0));
    check_distribution(executor.at("jitter_us"));
  }
  for (const json& module : array_in(report, "modules")) check_module(module);
  if (report.contains("clock") && !report.at("clock").is_null()) {
    check_texts(report.at("clock"), {"reference"});
    check_times(report.at("clock"), {"offset_us", "bound_us"});
  }
  if (report.contains("realtime_violations")) {
    for (const json& violation : array_in(report, "realtime_violations")) check_violation(violation);
  }
  return report;
}

Result<json> described_modules(const std::string& device, const std::string& data) {
  json modules;
  const auto read = read_answer(device, data, [&modules](const json& description) {
    modules = array_in(description, "modules");
    for (json& module : modules) {
      check_texts(module, {"name"});
      json& ports = module["ports"];  // in the format of model::ports_json(); null if they are not known
      ports = ports.is_null() ? json::array() : json(array_in(ports, "ports"));
      if (module["properties"].is_null()) module["properties"] = json::array();
      for (const char* list : {"ports", "properties"}) {
        for (const json& one : array_in(module, list)) check_texts(one, {"name"});
      }
    }
  });
  if (!read) return read.problems();
  return modules;
}

}  // namespace takt::client
