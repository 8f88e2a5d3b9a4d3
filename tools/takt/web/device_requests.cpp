#include "web/device_requests.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <takt/client/alarms.hpp>
#include <takt/client/answer_data.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/validation.hpp>
#include <takt/wire/words.hpp>

#include "web/period.hpp"
#include "web/property_values.hpp"

namespace takt::tool::web {

namespace {

using std::chrono::seconds;

constexpr seconds kLong{30};  // time limit of commands, because a component may be slow to stop

/// Splits "device.module" into two names. Returns none if the text is not valid.
std::optional<std::pair<std::string, std::string>> split(const std::string& name) {
  const std::size_t dot = name.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == name.size() ||
      name.find('.', dot + 1) != std::string::npos)
    return std::nullopt;
  return std::pair{name.substr(0, dot), name.substr(dot + 1)};
}

/// The string member `name` of a JSON object. Empty if it is missing or not a string.
std::string text_in(const Json& json, const char* name) {
  return json.is_object() && json.contains(name) && json[name].is_string() ? json[name].get<std::string>()
                                                                           : "";
}

/// The members of the JSON object in a request. None if the request has another member than the known ones,
/// or a member that is not a string. So a request with a mistake never becomes another request: without its
/// module, a command would go to all modules of the device.
std::optional<std::map<std::string, std::string>> members_of(const std::string& body,
                                                             const std::set<std::string>& known) {
  const Json json = model::parse_json(body);
  if (!json.is_object()) return std::nullopt;
  std::map<std::string, std::string> members;
  for (const auto& [name, value] : json.items()) {
    if (!known.contains(name) || !value.is_string()) return std::nullopt;
    members[name] = value.get<std::string>();
    if (name != "value" && name != "note" && (members[name].empty() || !wire::is_name(members[name])))
      return std::nullopt;
  }
  return members;
}

constexpr std::pair<const char*, CommandKind> kVerbs[] = {
    {"initialize", COMMAND_INITIALIZE}, {"start", COMMAND_START}, {"stop", COMMAND_STOP},
    {"recover", COMMAND_RECOVER},       {"reset", COMMAND_RESET}, {"destruct", COMMAND_DESTRUCT},
};

Answer rejected(const Result<wire::WholeReply>& reply) {
  if (!reply) return answer_of(504, reply.problems().front());
  const Problems problems = client::problems_of(*reply);
  Problem problem = problems.empty() ? fail("the node rejected the request", "") : problems.front();
  return answer_of(409, problem);
}

}  // namespace

Answer DeviceRequests::command(const std::string& body) {
  auto asked = members_of(body, {"device", "module", "verb"});
  const auto kind = std::find_if(std::begin(kVerbs), std::end(kVerbs), [&asked](const auto& known) {
    return asked && (*asked)["verb"] == known.first;
  });
  if (kind == std::end(kVerbs) || !asked->contains("device")) {
    return answer_of(400, fail("not a valid command: " + in_quotes(body.substr(0, 100)),
                               R"(send {"device": "d", "module": "m", "verb": "start"}, where verb is )"
                               "initialize, start, stop, recover, reset or destruct; without module, the "
                               "command goes to all modules of the device"));
  }
  const std::string module = (*asked)["module"];
  const client::CommandRequest request{
      .kind = kind->second, .device = (*asked)["device"], .module = module, .limit = kLong};
  if (const auto valid = client::check(request); !valid) return answer_of(400, valid.problems().front());
  const auto reply = sender_.send(request);
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  Json json{{"text", reply->head.text().to_string()}};
  if (!module.empty()) json["state"] = to_text(reply->head.state());
  return answer_of(json);
}

Answer DeviceRequests::acknowledge(const std::string& body) {
  auto asked = members_of(body, {"device", "module", "note", "alarm"});
  const auto number = asked ? model::whole_number(model::parse_json((*asked)["alarm"])) : std::nullopt;
  if (!number || !asked->contains("device")) {
    return answer_of(
        400, fail("not a valid acknowledgement: " + in_quotes(body.substr(0, 100)),
                  R"(send {"device": "d", "module": "m", "note": "text", "alarm": "17"}, where alarm is the )"
                  "number of the alarm, or 0 for all alarms of the module"));
  }
  const auto alarms =
      client::acknowledge(sender_, (*asked)["device"], (*asked)["module"], (*asked)["note"], *number);
  if (!alarms) return answer_of(409, alarms.problems().front());
  return answer_of(Json{{"acknowledged", alarms->size()}});
}

Answer DeviceRequests::set_property(const std::string& body) {
  auto asked = members_of(body, {"module", "property", "value"});
  const auto name = asked ? split((*asked)["module"]) : std::nullopt;
  if (!name || !asked->contains("property") || !asked->contains("value")) {
    return answer_of(400, fail("not a valid request to set a property: " + in_quotes(body.substr(0, 100)),
                               R"(send {"module": "d.m", "property": "p", "value": "1.5"})"));
  }
  const client::CommandRequest request{.kind = COMMAND_SET,
                                       .device = name->first,
                                       .module = name->second,
                                       .property = (*asked)["property"],
                                       .value = (*asked)["value"],
                                       .limit = kLong};
  if (const auto valid = client::check(request); !valid) return answer_of(400, valid.problems().front());
  const auto reply = sender_.send(request);
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  return answer_of(Json{{"value", reply->head.value().to_string()}});
}

// Asks a device for the description of its modules. Sets `modules`, or returns the answer that reports the
// failure.
Answer DeviceRequests::described(const std::string& device, Json& modules) {
  const auto reply = sender_.send({.kind = COMMAND_DESCRIBE, .device = device, .limit = seconds{10}});
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  auto all = client::described_modules(device, reply->data);
  if (!all) return answer_of(504, all.problems().front());
  modules = std::move(*all);
  return {};
}

Answer DeviceRequests::ports(const std::string& device) {
  Json modules;
  if (Answer answer = described(device, modules); answer.status != 200) return answer;
  Json ports = Json::array();
  Json components = Json::object();
  for (const Json& module : modules) {
    components[device + "." + text_in(module, "name")] = {{"file", text_in(module, "path")},
                                                          {"version", text_in(module, "version")},
                                                          {"hash", text_in(module, "hash")}};
    for (const Json& port : module.at("ports")) {
      ports.push_back({{"name", device + "." + text_in(module, "name") + "." + text_in(port, "name")},
                       {"direction", text_in(port, "direction")},
                       {"type", text_in(port, "type")}});
    }
  }
  return answer_of(Json{{"ports", std::move(ports)}, {"components", std::move(components)}});
}

Answer DeviceRequests::properties(const std::string& module) {
  const auto name = split(module);
  if (!name)
    return answer_of(400, fail(in_quotes(module) + " is not the name of a module", "write DEVICE.MODULE"));
  Json modules;
  if (Answer answer = described(name->first, modules); answer.status != 200) return answer;
  const auto found = std::find_if(modules.begin(), modules.end(),
                                  [&](const Json& one) { return text_in(one, "name") == name->second; });
  if (found == modules.end())
    return answer_of(404, fail("there is no module " + module, "list the modules with takt status"));
  Json properties = found->at("properties");
  // The page shows these texts as they are, so they must not change the direction of its text.
  for (Json& property : properties) {
    for (const char* const member : {"default", "range", "unit", "text"}) {
      if (const std::string text = text_in(property, member); !text.empty())
        property[member] = on_one_line(text);
    }
  }
  add_property_values(properties, sender_, name->first, name->second);
  return answer_of(Json{{"properties", std::move(properties)}});
}

Answer DeviceRequests::table(const std::string& device, const std::shared_ptr<const model::Cell>& running) {
  if (!running) return answer_of(409, fail("no cell is running", "deploy a cell with takt deploy FILE"));
  const auto found = std::find_if(running->devices.begin(), running->devices.end(),
                                  [&device](const model::Device& d) { return d.name == device; });
  if (found == running->devices.end())
    return answer_of(404, fail("cell " + running->name + " has no device " + in_quotes(device),
                               "list the devices with takt status"));
  const auto reply = sender_.send({.kind = COMMAND_TRACE,
                                   .device = device,
                                   .value = std::to_string(trace_needed(*running, *found).count()),
                                   .limit = seconds{10}});
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  const auto json = period_json(model::parse_json(reply->data), *running, *found);
  if (!json) return answer_of(409, json.problems().front());
  return answer_of(*json);
}

}  // namespace takt::tool::web
