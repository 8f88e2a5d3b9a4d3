// The last macro period of a device, from what its flight recorder kept: which row began when, which module
// took how long in it, and why something was late.
#pragma once

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::tool::web {

/// How far back a trace must go to hold a whole macro period of each executor of the device; at most 10 s.
Nanoseconds trace_needed(const model::Cell& cell, const model::Device& device);

/// {"executors": [{"name", "basic_period_ns", "macro_period_ns", "begin_ms", "rows": [...]}], "programs":
/// [...]}: of each executor the last macro period that had ended when the trace was taken, from its beginning
/// in ns; rows that were missed are not there. At most kMostRows rows. An executor whose macro period is
/// longer than the trace has the reason in "text" and no rows. Fails on what is no trace of takt, or of one
/// that has not begun its rows.
Result<nlohmann::ordered_json> period_json(const nlohmann::ordered_json& trace, const model::Cell& cell,
                                           const model::Device& device);

}  // namespace takt::tool::web
