// Describes the machine of a measurement, so that its numbers can be interpreted.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/os/platform.hpp>

namespace takt::bench {

/// Pairs of a property and its value. A missing value is "unknown" or a similar word.
std::vector<std::pair<std::string, std::string>> described(const os::Platform& machine);

/// The pairs of described() as text with one line per pair, for the head of a report.
std::string machine_text(const os::Platform& machine);
nlohmann::ordered_json machine_json(const os::Platform& machine);

/// "2026-11-21 18:15 UTC" from nanoseconds since 1970.
std::string date_text(std::int64_t wall_ns);

/// Microseconds with three significant digits: "0.05", "12.3", "1450".
std::string in_us(double ns);

}  // namespace takt::bench
