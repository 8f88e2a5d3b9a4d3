// The last macro period of a device, from its flight record: when each row began, how long each module ran in
// the row, and why a row or module was late.
#pragma once

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool::web {

/// How far back a trace must go to contain a complete macro period of each executor of the device. At most
/// 10 s.
Nanoseconds trace_needed(const model::Cell& cell, const model::Device& device);

/// {"executors": [{"name", "basic_period_ns", "macro_period_ns", "begin_ms", "rows": [...]}], "programs":
/// [...]}: for each executor the last macro period that was complete when the trace was taken. Times are in
/// ns from the beginning of the macro period. Missed rows are left out, and there are at most kMostRows rows.
/// An executor whose macro period is longer than the trace has no rows, and the reason in "text". Fails if
/// `trace` is not a Takt trace, or if the device has not yet run a row.
Result<nlohmann::ordered_json> period_json(const nlohmann::ordered_json& trace, const model::Cell& cell,
                                           const model::Device& device);

}  // namespace takt::tool::web
