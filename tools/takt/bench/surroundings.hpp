// Describes the machine on which the measurements ran, because their numbers depend on it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/os/platform.hpp>

namespace takt::bench {

/// The properties of the machine, as pairs of a name and a value. A missing value is "unknown" or a similar
/// word.
std::vector<std::pair<std::string, std::string>> described(const os::Platform& machine);

/// The properties from described() as text for the head of a report, one line per property.
std::string machine_text(const os::Platform& machine);
nlohmann::ordered_json machine_json(const os::Platform& machine);

/// Formats nanoseconds since 1970 as "2026-11-21 18:15 UTC".
std::string date_text(std::int64_t wall_ns);

/// Converts nanoseconds to microseconds as text, with about three significant digits: "0.05", "12.3", "1450".
std::string in_us(double ns);

}  // namespace takt::bench
