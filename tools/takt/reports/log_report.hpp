// The output of `takt log`: events as text or JSON.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/fault.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// Events as text, in local time. Each event has a line with time, module, kind and cause; a cause that does
/// not fit goes below. A change of the day gets its own line. `day` is the day of the previous event (empty:
/// none) and is updated.
std::string log_text(const std::vector<model::Fault>& events, std::string& day, Style style);
/// One JSON object per line.
std::string log_json(const std::vector<model::Fault>& events);

/// Converts "10m", "2h" (ago) or "14:30", "2026-03-01", "2026-03-01 14:30:05", also with a T (local time), to
/// ns since 1970. Fails with examples of valid times.
Result<std::int64_t> since_from(const std::string& text, std::int64_t now_ns);

}  // namespace takt::tool
