#include <takt/host/protocol.hpp>

#include <nlohmann/json.hpp>

#include <takt/model/hosts.hpp>
#include <takt/model/json.hpp>

namespace takt::host {

namespace {

using json = nlohmann::ordered_json;

json from_duration(const std::optional<Nanoseconds>& duration) {
  return duration ? json(duration->count()) : json(nullptr);
}
std::optional<Nanoseconds> to_duration(const json& value) {
  if (value.is_null()) return std::nullopt;
  return Nanoseconds{value.get<std::int64_t>()};
}

template <class T>
json from_optional(const std::optional<T>& value) {
  return value ? json(*value) : json(nullptr);
}
std::optional<int> to_number(const json& value) {
  if (value.is_null()) return std::nullopt;
  return value.get<int>();
}

json json_of(const model::OverrunContract& contract) { return {contract.what, contract.limit}; }
model::OverrunContract contract_from(const json& value) { return {value[0], value[1]}; }

json json_of(const model::Module& module) {
  json properties = json::array();
  for (const auto& property : module.properties) properties.push_back({property.name, property.value});
  return {{"name", module.name},
          {"filename", module.filename},
          {"type", module.type},
          {"operation", module.operation},
          {"period", from_duration(module.period)},
          {"deadline", from_duration(module.deadline)},
          {"miss", module.miss},
          {"dispatch", module.dispatch},
          {"interarrival", from_duration(module.interarrival)},
          {"priority", module.priority},
          {"executor", module.executor},
          {"offset", from_duration(module.offset)},
          {"budget", from_duration(module.budget)},
          {"times", from_optional(module.tolerance.times)},
          {"in_a_row", from_optional(module.tolerance.in_a_row)},
          {"overrun", module.overrun ? json_of(*module.overrun) : json(nullptr)},
          {"properties", properties}};
}

model::Module module_from(const json& value) {
  model::Module module;
  module.name = value.at("name");
  module.filename = value.at("filename");
  module.type = value.at("type");
  module.operation = value.at("operation");
  module.period = to_duration(value.at("period"));
  module.deadline = to_duration(value.at("deadline"));
  module.miss = value.at("miss");
  module.dispatch = value.at("dispatch");
  module.interarrival = to_duration(value.at("interarrival"));
  module.priority = value.at("priority");
  module.executor = value.at("executor");
  module.offset = to_duration(value.at("offset"));
  module.budget = to_duration(value.at("budget"));
  module.tolerance = {to_number(value.at("times")), to_number(value.at("in_a_row"))};
  if (!value.at("overrun").is_null()) module.overrun = contract_from(value.at("overrun"));
  for (const json& property : value.at("properties"))
    module.properties.push_back({.name = property[0], .value = property[1]});
  return module;
}

json json_of(const model::Executor& executor) {
  return {
      {"name", executor.name},       {"priority", executor.priority}, {"auto", executor.rate_monotonic},
      {"wakeup", executor.wakeup},   {"spin", executor.spin_share},   {"overrun", json_of(executor.overrun)},
      {"offsets", executor.offsets}, {"timing", executor.timing},     {"own_host", executor.own_host}};
}

model::Executor executor_from(const json& value) {
  model::Executor executor;
  executor.name = value.at("name");
  executor.priority = value.at("priority");
  executor.rate_monotonic = value.at("auto");
  executor.wakeup = value.at("wakeup");
  executor.spin_share = value.at("spin");
  executor.overrun = contract_from(value.at("overrun"));
  executor.offsets = value.at("offsets");
  executor.timing = value.at("timing");
  executor.own_host = value.at("own_host");
  return executor;
}

json json_of(const Request& request) {
  return {{"do", request.what},         {"module", request.module}, {"hook", request.hook},
          {"type", request.error_type}, {"id", request.id},         {"property", request.property},
          {"value", request.value},     {"values", request.values}, {"signed", request.is_signed}};
}

Request request_from(const json& value) {
  return {.what = value.at("do"),
          .module = value.at("module"),
          .hook = value.at("hook"),
          .error_type = value.at("type"),
          .id = value.at("id"),
          .property = value.at("property"),
          .value = value.at("value"),
          .values = value.at("values"),
          .is_signed = value.at("signed")};
}

template <class T, class Read>
Result<T> decoded(const std::string& text, Read&& read) {
  try {
    return T{read(model::parse_json(text))};
  } catch (const json::exception& exception) {
    return fail(std::string{"a message between node and host cannot be read: "} + exception.what(),
                "install takt-node and takt-host of the same version");
  }
}

}  // namespace

std::string encode(const Setup& setup) {
  json modules = json::array();
  for (const auto& module : setup.device.modules) modules.push_back(json_of(module));
  json executors = json::array();
  for (const auto& executor : setup.device.executors) executors.push_back(json_of(executor));
  json links = json::array();
  for (const PortLink& link : setup.links)
    links.push_back({link.module, link.port, link.fd, link.typed, link.stale_is_error});
  return model::json_text({{"name", setup.device.name},
                           {"modules", modules},
                           {"executors", executors},
                           {"share", setup.share},
                           {"paths", setup.paths},
                           {"executor_cpus", setup.executor_cpus},
                           {"background_cpus", setup.background_cpus},
                           {"slot_fds", setup.slot_fds},
                           {"wake_word_fd", setup.wake_word_fd},
                           {"saved_fd", setup.saved_fd},
                           {"links", links}});
}

std::string encode(const Request& request) { return model::json_text(json_of(request)); }

std::string encode(const Answer& answer) {
  return model::json_text({{"request", json_of(answer.request)},
                           {"ok", answer.ok},
                           {"text", answer.text},
                           {"warnings", answer.warnings}});
}

Result<Setup> decode_setup(const std::string& text) {
  return decoded<Setup>(text, [](const json& value) {
    Setup setup;
    setup.device.name = value.at("name");
    for (const json& module : value.at("modules")) setup.device.modules.push_back(module_from(module));
    for (const json& executor : value.at("executors"))
      setup.device.executors.push_back(executor_from(executor));
    setup.share = value.at("share");
    if (setup.share >= model::hosts_of(setup.device).size())
      throw json::other_error::create(501, "the device has no host with this index", nullptr);
    setup.paths = value.at("paths").get<std::vector<std::string>>();
    setup.executor_cpus = value.at("executor_cpus").get<std::vector<std::vector<int>>>();
    setup.background_cpus = value.at("background_cpus").get<std::vector<int>>();
    setup.slot_fds = value.at("slot_fds").get<std::vector<int>>();
    setup.wake_word_fd = value.at("wake_word_fd");
    setup.saved_fd = value.at("saved_fd");
    for (const json& link : value.at("links"))
      setup.links.push_back({link[0], link[1], link[2], link[3], link[4]});
    return setup;
  });
}

Result<Request> decode_request(const std::string& text) { return decoded<Request>(text, request_from); }

Result<Answer> decode_answer(const std::string& text) {
  return decoded<Answer>(text, [](const json& value) {
    return Answer{request_from(value.at("request")), value.at("ok"), value.at("text"),
                  value.at("warnings").get<std::vector<std::string>>()};
  });
}

}  // namespace takt::host
