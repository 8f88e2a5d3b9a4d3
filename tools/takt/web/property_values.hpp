// Reads the values of a module's properties.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>

namespace takt::tool {

/// Adds the member "value" to each property of a module: its value as a text, or null if the device does not
/// answer, or cannot know the value because the module does not run. `properties` is a list as in the answer
/// to COMMAND_DESCRIBE.
void add_property_values(nlohmann::ordered_json& properties, client::Operator& sender,
                         const std::string& device, const std::string& module);

}  // namespace takt::tool
