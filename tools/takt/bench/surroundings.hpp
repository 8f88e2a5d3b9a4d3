// What must be known of the machine to read a number that was measured on it, and what was taken from it
// meanwhile.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/os/platform.hpp>

namespace takt::bench {

/// One line each: what, and how it is; "none" and the like where there is nothing.
std::vector<std::pair<std::string, std::string>> described(const os::Platform& machine);

/// The same as a text that begins every report: a line each.
std::string machine_text(const os::Platform& machine);
nlohmann::ordered_json machine_json(const os::Platform& machine);

/// "2026-11-21 18:15 UTC", of nanoseconds since 1970.
std::string date_text(std::int64_t wall_ns);

/// Microseconds with three digits that matter: "0.05", "12.3", "1450".
std::string in_us(double ns);

}  // namespace takt::bench
