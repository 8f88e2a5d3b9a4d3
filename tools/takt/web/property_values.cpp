#include "web/property_values.hpp"

#include <chrono>
#include <vector>

namespace takt::tool {

void add_property_values(nlohmann::ordered_json& properties, client::Operator& sender,
                         const std::string& device, const std::string& module) {
  std::vector<client::CommandRequest> requests;
  for (const auto& property : properties) {
    requests.push_back({.kind = COMMAND_GET,
                        .device = device,
                        .module = module,
                        .property = property.at("name").get<std::string>(),
                        .limit = std::chrono::seconds{3}});
  }
  const auto replies = sender.send(requests);
  for (std::size_t i = 0; i < replies.size(); ++i) {
    const bool there = replies[i] && replies[i]->head.code() == REPLY_OK;
    properties[i]["value"] =
        there ? nlohmann::ordered_json(replies[i]->head.value().to_string()) : nlohmann::ordered_json();
  }
}

}  // namespace takt::tool
