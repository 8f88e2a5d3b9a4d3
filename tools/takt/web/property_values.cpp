#include "web/property_values.hpp"

#include <chrono>
#include <vector>

#include <takt/core/log_level.hpp>

namespace takt::tool {

namespace {

using Json = nlohmann::ordered_json;

}  // namespace

const model::Module* program_of(const model::Cell* cell, const std::string& device, const std::string& name) {
  if (cell == nullptr) return nullptr;
  for (const model::Device& each : cell->devices) {
    if (each.name != device) continue;
    for (const model::Module& module : each.modules) {
      if (module.name == name && module.type == model::ModuleType::process) return &module;
    }
  }
  return nullptr;
}

void add_property_values(Json& properties, client::Operator& sender, const std::string& device,
                         const std::string& module, const model::Cell* cell) {
  const model::Module* const program = program_of(cell, device, module);
  std::vector<client::CommandRequest> requests;
  std::vector<Json*> asked;
  for (Json& property : properties) {
    const auto name = property.at("name").get<std::string>();
    // A process module keeps the property values with which it was started, so they come from the descriptor.
    // Its node rejects requests for properties that are not in the descriptor.
    if (program != nullptr && name != kLogLevelProperty) {
      const auto given = model::given_property(*program, name);
      property["value"] = given ? Json(*given) : property.value("default", Json());
      continue;
    }
    asked.push_back(&property);
    requests.push_back({.kind = COMMAND_GET,
                        .device = device,
                        .module = module,
                        .property = name,
                        .limit = std::chrono::seconds{3}});
  }
  const auto replies = sender.send(requests);
  for (std::size_t i = 0; i < asked.size(); ++i) {
    const bool there = replies[i] && replies[i]->head.code() == REPLY_OK;
    (*asked[i])["value"] = there ? Json(replies[i]->head.value().to_string()) : Json();
  }
}

}  // namespace takt::tool
