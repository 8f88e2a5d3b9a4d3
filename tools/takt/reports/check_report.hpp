// What `takt check` says about a cell that is in order: for a person, for a program, and as a picture.
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

/// All three take the plans of the cell's devices, in their order, as schedule::plan(cell) gives them.

/// Periods, tables and predicted load of each executor. No line is wider than 100 columns, and a table has at
/// most kTextRows lines: rows that follow each other and are equal share one, and what is left out is
/// counted. Ends with a line feed.
/// With a proof, beside them how long each module may take from its release.
std::string check_text(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans, Style style,
                       const std::optional<Proof>& proof = std::nullopt);
inline constexpr std::size_t kTextRows = 40;

/// The object that `takt check --json` prints, with every row. Its keys and their order are the contract. A
/// proof adds "worst_case" to each device: `{"processors": n, "factor": x, "run_times": "profile" |
/// "budgets", "modules": [{"name": str, "cpus": [n], "run_ns": n, "response_ns": n | null, "deadline_ns": n,
/// "slack_ns": n | null, "kept": bool, "why": str}]}`, with "why" where a deadline is not kept for another
/// reason than its response.
nlohmann::ordered_json check_json(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                                  const std::optional<Proof>& proof = std::nullopt);

/// One panel an executor: a lane for each module over the rows of one macro period. Draws the first kSvgRows
/// rows and the first kSvgLanes modules of each kind, and says so where there are more.
std::string check_svg(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans);
inline constexpr std::size_t kSvgRows = 64;
inline constexpr std::size_t kSvgLanes = 100;

}  // namespace takt::tool
