// Makes the output of `takt log` and `takt alarms`, which show events and alarms as text or JSON.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/alarm.hpp>
#include <takt/model/fault.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// Converts events to text, with local times. Each event has a line with time, module, kind and cause. If the
/// cause does not fit, it goes on the next lines. Each new day gets its own line. `day` is the day of the
/// previous event, or empty, and is updated.
std::string log_text(const std::vector<model::Fault>& events, std::string& day, Style style);
/// Converts events to JSON, one object per line.
std::string log_json(const std::vector<model::Fault>& events);

/// Converts alarms to text, with local times: a line with the module, the kind, the state and the time, then
/// the cause, then the acknowledgement.
std::string alarms_text(const std::vector<model::Alarm>& alarms, Style style);

/// Converts an age ("10m", "2h") or a local time ("14:30", "2026-03-01", "2026-03-01 14:30:05",
/// "2026-03-01T14:30:05") to ns since 1970. If the text is not valid, the problem gives examples.
Result<std::int64_t> since_from(const std::string& text, std::int64_t now_ns);

}  // namespace takt::tool
