// What `takt log` prints.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/fault.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// Events for a person, in local time: a line with time, module, kind and cause; of a longer cause the rest
/// below it. `day` is that of the line before ("": there is none), for a line of its own where it changes.
std::string log_text(const std::vector<model::Fault>& events, std::string& day, Style style);
/// One object a line.
std::string log_json(const std::vector<model::Fault>& events);

/// The instant (since 1970, ns) that "10m", "2h", "14:30", "2026-03-01", "2026-03-01 14:30:05" or the same
/// with a T means, in local time. Fails with what would be right.
Result<std::int64_t> since_from(const std::string& text, std::int64_t now_ns);

}  // namespace takt::tool
