// What `takt run` says when it ends.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// The status object of the contract as tables, one line an executor and one a module, at most 100 columns
/// wide for names of up to 20 characters. Times in microseconds. Ends with a line feed.
std::string run_text(const nlohmann::ordered_json& status);
/// The same for programs: without what is for people only (the margins of the executors). Ends with a line
/// feed.
std::string run_json(nlohmann::ordered_json status);

}  // namespace takt::tool
