// Reads the values of a module's properties.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool {

/// Returns the module with this name if it is a process module of the cell; otherwise null. `cell` may be
/// null.
const model::Module* program_of(const model::Cell* cell, const std::string& device, const std::string& name);

/// Adds the member "value" to each property of a module: its value as a text, or null if the device does not
/// answer. `properties` is a list as in the answer to COMMAND_DESCRIBE. `cell` is the running cell; null if
/// it is not known.
void add_property_values(nlohmann::ordered_json& properties, client::Operator& sender,
                         const std::string& device, const std::string& module, const model::Cell* cell);

}  // namespace takt::tool
