// Converts the samples that nodes publish to the JSON that web pages get. The functions are pure, so their
// tests need no network. README.md in this folder lists the JSON members.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/model/alarm.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>
#include <takt/recording/columns.hpp>
#include <takt/wire/cell_state.hpp>

#include "reports/graph_report.hpp"

namespace takt::tool::web {

using Json = nlohmann::ordered_json;

Json device_json(const wire::ObservedDevice& device);
/// The current state of a module, or its transition to a new state.
Json module_json(const LifecycleStatus& status);
Json fault_json(const model::Fault& fault);
Json alarm_json(const model::Alarm& alarm);

/// The measurements of all modules, executors and connections. `cell` is the running cell, or null if none is
/// known.
Json measures_json(const std::vector<wire::ObservedDevice>& devices, const model::Cell* cell,
                   std::int64_t time_ns);

/// The running cell as the descriptor describes it, with its tables, and its graph as SVG. `cell` is null if
/// no running cell is known.
Json cell_json(const model::Cell* cell, int domain, const std::string& deployment);
/// The graph of the cell as SVG, to which the page adds the states and values.
std::string graph_of(const model::Cell& cell, const GraphPage& page);
/// At most this many rows of an executor's table are sent to pages, because a table may have a million rows.
inline constexpr std::size_t kMostRows = 200;

/// True if the reports of the module's outputs say that the module is in a safe stop.
bool in_safe_stop(const wire::ObservedDevice& device, const std::string& module);
/// Returns the inputs of a module that are forced, with who forces them: "command by operator anna". Empty if
/// there is none.
std::string forced_inputs(const wire::ObservedDevice& device, const std::string& module);

/// A sample in a few letters: its first number, truth value or enumerator, and how many more values it has,
/// as in "0.5236 +5"; "3 fields" if it has only texts.
std::string short_text(const recording::Columns& columns, const std::vector<recording::Value>& values);

ObservedCell::Port observed(const wire::ObservedPort& port);
/// The health of a cell's devices, modules and connections.
CellHealth health_of(const model::Cell& cell, const std::vector<wire::ObservedDevice>& devices);

}  // namespace takt::tool::web
