// The output of `takt check` for a valid cell: as text, as JSON, and as a drawing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>

#include "commands/proof.hpp"
#include "reports/style.hpp"

namespace takt::tool {

/// All three functions take the plans of the cell's devices as schedule::plan(cell) returns them.

/// Periods, tables and predicted load of each executor. With a proof, also the worst-case response time of
/// each module. No line is wider than 100 columns. Equal consecutive rows share a line, a table has at most
/// kTextRows lines, and the rest is counted. Ends with a line feed.
std::string check_text(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans, Style style,
                       const std::optional<Proof>& proof = std::nullopt);
inline constexpr std::size_t kTextRows = 40;

/// The object that `takt check --json` prints, with every row. Its keys and their order must not change. A
/// proof adds "worst_case" to each device: `{"processors": n, "factor": x, "run_times": "profile" |
/// "budgets", "modules": [{"name": str, "cpus": [n], "run_ns": n, "response_ns": n | null, "deadline_ns": n,
/// "slack_ns": n | null, "kept": bool, "why": str}]}`. "why" is present if a deadline is not kept and the
/// response time is not the reason.
nlohmann::ordered_json check_json(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                                  const std::optional<Proof>& proof = std::nullopt);

/// The tables as SVG. Each executor has a panel with a lane for each module, over the rows of one macro
/// period. Draws the first kSvgRows rows and the first kSvgLanes modules of each kind; a note says how many
/// more there are.
std::string check_svg(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans);
inline constexpr std::size_t kSvgRows = 64;
inline constexpr std::size_t kSvgLanes = 100;

}  // namespace takt::tool
