// The output of `takt doctor`.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// The object of `takt doctor --json` as text: first what spoils real time, then the notes, each with its
/// reason and its cure, then one line for each check that is good. A command is never wrapped, so that it can
/// be copied. Ends with a line feed.
std::string doctor_text(const nlohmann::ordered_json& report, Style style);

}  // namespace takt::tool
