// Makes the output of `takt graph`: the devices, modules and connections of a cell, and, if the cell is
// running, their health. The output is text, JSON or a drawing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/wire/judgement.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// The health of a running cell, from the reports of its devices. If no report mentions a device, module or
/// connection, it is missing here and is drawn as if the cell were not running.
struct CellHealth {
  struct Device {
    bool alive = true;
    std::string text{};  ///< the reason if the device's health is not good, or empty
  };
  using Connection = wire::ConnectionReport;
  std::map<std::string, Device> devices;       ///< for each device, by its name
  std::map<std::string, std::string> modules;  ///< the state of each module ("EXECUTING"), by "device.module"
  std::set<std::string> given_up{};    ///< the modules in DESTRUCT that the node gave up, by "device.module"
  std::set<std::string> safe_stops{};  ///< the modules in a safe stop
  std::map<std::size_t, Connection> connections;  ///< for each connection, by its index in Cell::connections
};

/// The reports of the devices of a cell. The keys are the names "device", "device.module" and
/// "device.module.port".
struct ObservedCell {
  struct Port {
    bool matched = false;
    bool safe = false;
    std::optional<Nanoseconds> age{};
    bool losing = false;
    bool dropping = false;
    std::uint64_t lost = 0;
    std::uint64_t dropped = 0;
    std::uint64_t late = 0;
    std::string incompatible{};
    std::string forced{};
  };
  std::map<std::string, CellHealth::Device> devices{};
  std::map<std::string, std::string> modules{};
  std::set<std::string> given_up{};
  std::set<std::string> safe_stops{};
  std::map<std::string, Port> ports{};
};
/// Derives the health of a cell from the reports of its devices.
CellHealth health_of(const model::Cell& cell, const ObservedCell& observed);
/// The health of the connection at one port. `connection` is the connection that ends at the port, or null if
/// none is known. `end_lost` is true if the device at either end of the connection is lost.
CellHealth::Connection health_of(const ObservedCell::Port& port, const model::Connection* connection,
                                 bool end_lost);

/// The health of a cell, from the object that `takt status --json` prints. Empty if the object has no device
/// of this cell.
CellHealth health_of(const model::Cell& cell, const nlohmann::ordered_json& status);

/// The judgement of a connection as text, with the age and the counters: "NOT MATCHED: reliability",
/// "STALE, 400 ms old, late 2", "degraded: loses samples, 1.2 ms old, lost 3", "ok, 1.2 ms old".
std::string health_text(const CellHealth::Connection& health);

/// Lists the devices, modules and connections as text, with the same width as check_text(). The text ends
/// with a line feed.
std::string graph_text(const model::Cell& cell, const CellHealth& health, Style style);

/// {"cell", "domain", "discovery", "devices": [{"name", "modules": [{"name", "type", "operation", ...}]}],
/// "connections": [{"from", "to", "kind", ...}]}. Times are in ns. Members without a known value are left
/// out. An end outside Takt is null.
nlohmann::ordered_json graph_json(const model::Cell& cell, const CellHealth& health);

/// How to draw the graph for a page that shows the running cell in it.
struct GraphPage {
  std::set<std::string> collapsed{};  ///< the devices that are one box, without their modules
};
/// Draws the cell as SVG: a box for each device with its modules and their connected ports, and an arrow for
/// each connection. For a page, the drawing has room for the measurements, a control that collapses each
/// device, and the whole legend. All connections between a collapsed device and one port, or another
/// collapsed device, are one arrow. The drawing has at most kGraphDevices devices, kGraphModules modules per
/// device and kGraphConnections connections; a note counts the rest. Words and line styles show the health,
/// not only colours.
std::string graph_svg(const model::Cell& cell, const CellHealth& health, const GraphPage* page = nullptr);
inline constexpr std::size_t kGraphDevices = 50;
inline constexpr std::size_t kGraphModules = 100;
inline constexpr std::size_t kGraphConnections = 500;

}  // namespace takt::tool
