// What nodes say, as the page of a cell is told it. Pure: tests read it without a network. The members are
// those that the page of this folder names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/dds/cell_state.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>

#include "reports/graph_report.hpp"

namespace takt::tool::web {

using Json = nlohmann::ordered_json;

Json device_json(const dds::ObservedDevice& device);
/// A state as it is, or a step to it.
Json module_json(const LifecycleStatus& status);
Json fault_json(const model::Fault& fault);

/// What is measured of all modules, executors and connections. `cell`: what runs; null: not known.
Json measures_json(const std::vector<dds::ObservedDevice>& devices, const model::Cell* cell,
                   std::int64_t time_ns);

/// What runs, as its descriptor says, with the tables and the cell_state of it. `cell` null: nothing is known
/// to run.
Json cell_json(const model::Cell* cell, int domain, const std::string& deployment);
/// Rows of an executor's table that are told; it may have a million.
inline constexpr std::size_t kMostRows = 200;

HeardCell::Port heard_of(const PortStatus& port);
/// How the connections of a cell are.
CellHealth health_of(const model::Cell& cell, const std::vector<dds::ObservedDevice>& devices);

}  // namespace takt::tool::web
