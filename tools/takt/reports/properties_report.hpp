// The report of `takt get DEVICE.MODULE`: all properties of a module.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// A table of the properties, one per row. `properties` is a list of objects as in the answer to
/// COMMAND_DESCRIBE, each with a member "value": a text, or null if the value is not known.
std::string properties_text(const nlohmann::ordered_json& properties, Style style);

}  // namespace takt::tool
