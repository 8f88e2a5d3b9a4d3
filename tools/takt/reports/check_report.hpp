// Makes the output of `takt check` for a valid cell: as text, as JSON, and as a drawing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>
#include <takt/schedule/plan.hpp>

#include "commands/proof.hpp"
#include "reports/style.hpp"

namespace takt::tool {

/// The argument `plans` of the three functions below contains the plan of each device, as
/// schedule::plan(cell) returns them.

/// The text shows the periods, the tables and the predicted load of each executor. With a proof, it also
/// shows the worst-case response time of each module. For each module whose `ports` are known, it lists the
/// inputs without a connection. No line is wider than 100 columns. Equal consecutive rows share a line. A
/// table has at most kTextRows lines; a note counts the rest. The text ends with a line feed.
std::string check_text(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans, Style style,
                       const std::optional<Proof>& proof = std::nullopt, const model::CellPorts& ports = {});
inline constexpr std::size_t kTextRows = 40;

/// The object that `takt check --json` prints, with all rows. The keys and their order must not change. If
/// there is a proof, each device has a member "worst_case": `{"processors": n, "factor": x, "run_times":
/// "profile" | "budgets", "modules": [{"name": str, "cpus": [n], "run_ns": n, "response_ns": n | null,
/// "deadline_ns": n, "slack_ns": n | null, "kept": bool, "why": str}]}`. "why" gives the reason why a
/// deadline is not kept. It is empty if the reason is that the response time is longer than the deadline.
nlohmann::ordered_json check_json(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                                  const std::optional<Proof>& proof = std::nullopt);

/// Draws the tables as SVG. Each executor has a panel over the rows of one macro period, with a lane for each
/// module. A panel has at most kSvgRows rows, kSvgLanes periodic modules and kSvgLanes sporadic modules; a
/// note counts the rest.
std::string check_svg(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans);
inline constexpr std::size_t kSvgRows = 64;
inline constexpr std::size_t kSvgLanes = 100;

}  // namespace takt::tool
