#include "web/questions.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/wire/words.hpp>

#include "web/period.hpp"

namespace takt::tool::web {

namespace {

using std::chrono::seconds;

constexpr seconds kQuestionAnswered{3};
constexpr seconds kLong{30};  // time limit of commands, because a component may be slow to stop

/// Splits "device.module". None if the name is not valid.
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

/// The process module with this name. Null if the cell has no such module, or if no cell is known.
const model::Module* program_of(const model::Cell* cell, const std::pair<std::string, std::string>& name) {
  if (cell == nullptr) return nullptr;
  for (const model::Device& device : cell->devices) {
    if (device.name != name.first) continue;
    for (const model::Module& module : device.modules) {
      if (module.name == name.second && module.type == model::ModuleType::process) return &module;
    }
  }
  return nullptr;
}

}  // namespace

Answer answer_of(const Json& json) { return {200, model::json_text(json)}; }

Answer answer_of(int status, const Problem& problem) {
  const std::string where = problem.where.empty() ? "" : problem.where + ": ";
  return {status, model::json_text({{"what", where + problem.what}, {"fix", problem.fix}})};
}

Answer Questions::command(const std::string& body) {
  const Json asked = model::parse_json(body);
  const std::string verb = text_in(asked, "verb");
  const std::string device = text_in(asked, "device");
  const auto kind = std::find_if(std::begin(kVerbs), std::end(kVerbs),
                                 [&verb](const auto& known) { return verb == known.first; });
  if (kind == std::end(kVerbs) || device.empty()) {
    return answer_of(400, fail("not a valid command: " + in_quotes(body.substr(0, 100)),
                               R"(send {"device": "d", "module": "m", "verb": "start"}, where verb is )"
                               "initialize, start, stop, recover, reset or destruct"));
  }
  const auto reply = asker_.ask(
      {.kind = kind->second, .device = device, .module = text_in(asked, "module"), .limit = kLong});
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  Json json{{"text", reply->head.text().to_string()}};
  if (!text_in(asked, "module").empty()) json["state"] = to_text(reply->head.state());
  return answer_of(json);
}

Answer Questions::set_property(const std::string& body) {
  const Json asked = model::parse_json(body);
  const auto name = split(text_in(asked, "module"));
  const std::string property = text_in(asked, "property");
  if (!name || property.empty() || !asked.contains("value") || !asked["value"].is_string()) {
    return answer_of(400, fail("not a valid request to set a property: " + in_quotes(body.substr(0, 100)),
                               R"(send {"module": "d.m", "property": "p", "value": "1.5"})"));
  }
  const auto reply = asker_.ask({.kind = COMMAND_SET,
                                 .device = name->first,
                                 .module = name->second,
                                 .property = property,
                                 .value = text_in(asked, "value"),
                                 .limit = kLong});
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  return answer_of(Json{{"value", reply->head.value().to_string()}});
}

// Asks a device for the description of its modules. Sets `description`, or returns the answer that reports
// the failure.
Answer Questions::described(const std::string& device, Json& description) {
  const auto reply = asker_.ask({.kind = COMMAND_DESCRIBE, .device = device, .limit = seconds{10}});
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  description = model::parse_json(reply->data);
  if (!description.is_object() || !description.contains("modules"))
    return answer_of(504, fail("the device's answer is from another version of Takt",
                               "install the same version on all machines"));
  return {};
}

Answer Questions::ports(const std::string& device) {
  Json description;
  if (Answer answer = described(device, description); answer.status != 200) return answer;
  Json ports = Json::array();
  for (const Json& module : description["modules"]) {
    const auto known = module.find("ports");  // in the format of model::ports_json(); null: not known
    if (known == module.end() || !known->is_object() || !known->contains("ports")) continue;
    for (const Json& port : (*known)["ports"]) {
      ports.push_back({{"name", device + "." + text_in(module, "name") + "." + text_in(port, "name")},
                       {"direction", text_in(port, "direction")},
                       {"type", text_in(port, "type")}});
    }
  }
  return answer_of(Json{{"ports", std::move(ports)}});
}

Answer Questions::properties(const std::string& module, const std::shared_ptr<const model::Cell>& running) {
  const auto name = split(module);
  if (!name)
    return answer_of(400, fail(in_quotes(module) + " is not the name of a module", "write DEVICE.MODULE"));
  Json description;
  if (Answer answer = described(name->first, description); answer.status != 200) return answer;
  const Json& modules = description["modules"];
  const auto found = std::find_if(modules.begin(), modules.end(),
                                  [&](const Json& one) { return text_in(one, "name") == name->second; });
  if (found == modules.end())
    return answer_of(404, fail("there is no module " + module, "list the modules with takt status"));
  Json properties = found->contains("properties") && (*found)["properties"].is_array()
                        ? (*found)["properties"]
                        : Json::array();
  // A process module keeps the property values with which it was started, so they come from the descriptor.
  // Its node rejects requests for properties that are not in the descriptor.
  if (const model::Module* const program = program_of(running.get(), *name)) {
    for (Json& property : properties) {
      const auto given = model::given_property(*program, text_in(property, "name"));
      property["value"] = given ? Json(*given) : property.value("default", Json());
    }
    return answer_of(Json{{"properties", std::move(properties)}});
  }
  std::vector<client::Question> questions;
  for (const Json& property : properties)
    questions.push_back({.kind = COMMAND_GET,
                         .device = name->first,
                         .module = name->second,
                         .property = text_in(property, "name"),
                         .limit = kQuestionAnswered});
  const auto replies = asker_.ask(questions);
  for (std::size_t i = 0; i < properties.size(); ++i) {
    const bool there = replies[i] && replies[i]->head.code() == REPLY_OK;
    properties[i]["value"] = there ? Json(replies[i]->head.value().to_string()) : Json();
  }
  return answer_of(Json{{"properties", std::move(properties)}});
}

Answer Questions::table(const std::string& device, const std::shared_ptr<const model::Cell>& running) {
  if (!running) return answer_of(409, fail("no cell is running", "deploy a cell with takt deploy FILE"));
  const auto found = std::find_if(running->devices.begin(), running->devices.end(),
                                  [&device](const model::Device& d) { return d.name == device; });
  if (found == running->devices.end())
    return answer_of(404, fail("cell " + running->name + " has no device " + in_quotes(device),
                               "list the devices with takt status"));
  const auto reply = asker_.ask({.kind = COMMAND_TRACE,
                                 .device = device,
                                 .value = std::to_string(trace_needed(*running, *found).count()),
                                 .limit = seconds{10}});
  if (!reply || reply->head.code() != REPLY_OK) return rejected(reply);
  const auto json = period_json(model::parse_json(reply->data), *running, *found);
  if (!json) return answer_of(409, json.problems().front());
  return answer_of(*json);
}

}  // namespace takt::tool::web
