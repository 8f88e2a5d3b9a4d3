// Converts what nodes publish to the JSON that pages get. Pure functions, so that tests need no network.
// README.md in this folder lists the members.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>
#include <takt/wire/cell_state.hpp>

#include "reports/graph_report.hpp"

namespace takt::tool::web {

using Json = nlohmann::ordered_json;

Json device_json(const wire::ObservedDevice& device);
/// The current state of a module, or a step to a new state.
Json module_json(const LifecycleStatus& status);
Json fault_json(const model::Fault& fault);

/// The measurements of all modules, executors and connections. `cell`: the running cell; null: not known.
Json measures_json(const std::vector<wire::ObservedDevice>& devices, const model::Cell* cell,
                   std::int64_t time_ns);

/// The running cell as the descriptor describes it, with its tables and its graph as SVG. `cell`: null if no
/// cell is known to run.
Json cell_json(const model::Cell* cell, int domain, const std::string& deployment);
/// The maximum number of rows of an executor's table that is sent; a table may have a million rows.
inline constexpr std::size_t kMostRows = 200;

ObservedCell::Port observed(const PortStatus& port);
/// The health of the connections of a cell.
CellHealth health_of(const model::Cell& cell, const std::vector<wire::ObservedDevice>& devices);

}  // namespace takt::tool::web
