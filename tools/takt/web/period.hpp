// Finds the last macro period of a device in its trace: when each row began, how long each module ran in the
// row, and why a row or module was late.
#pragma once

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool::web {

/// The length that a trace needs to contain a complete macro period of each executor of the device, but at
/// most 10 s.
Nanoseconds trace_needed(const model::Cell& cell, const model::Device& device);

/// {"executors": [{"name", "basic_period_ns", "macro_period_ns", "begin_ms", "rows": [...]}], "programs":
/// [...]}: for each executor, the last complete macro period in the trace. Times are in ns from the beginning
/// of the macro period. Missed rows are omitted, and each executor has at most kMostRows rows. If the macro
/// period of an executor is longer than the trace, "rows" is empty and "text" gives the reason. Fails if
/// `trace` is not a Takt trace, or if the device has not yet run a row.
Result<nlohmann::ordered_json> period_json(const nlohmann::ordered_json& trace, const model::Cell& cell,
                                           const model::Device& device);

}  // namespace takt::tool::web
