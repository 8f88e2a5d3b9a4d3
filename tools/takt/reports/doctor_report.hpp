// Makes the text that `takt doctor` prints.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// Converts the object of `takt doctor --json` to text. First come the findings that spoil real-time
/// behaviour, then the notes, each with its reason and its cure. Then comes one line for each check that
/// found nothing. A command is never wrapped, so that the user can copy it. The text ends with a line feed.
std::string doctor_text(const nlohmann::ordered_json& report, Style style);

}  // namespace takt::tool
