// What `takt doctor` says.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// The object of `takt doctor --json` for a person: what spoils real time first, then the notes, each with
/// its reason and its cure, then what is good, a line each. A command stands alone on its line, however long,
/// so that it can be copied. Ends with a line feed.
std::string doctor_text(const nlohmann::ordered_json& report, Style style);

}  // namespace takt::tool
