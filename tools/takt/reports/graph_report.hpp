// Makes the output of `takt graph`: the devices, modules and connections of a cell, and, if the cell is
// running, their health. The output is text, JSON or a drawing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// The health of a running cell, from the reports of its devices. If no report mentions a device, module or
/// connection, it is missing here and is drawn as if the cell were not running.
struct CellHealth {
  struct Device {
    bool alive = true;
    std::string text{};  ///< the reason if the device's health is not good, or empty
  };
  struct Connection {
    bool matched = true;               ///< the writer and the reader have found each other
    bool outside = false;              ///< one end is another program, which may not run yet
    bool stale = false;                ///< the newest value is older than the deadline
    bool safe = false;                 ///< the reader gets the safe value now
    std::optional<Nanoseconds> age{};  ///< the age of the newest value; none if there is no value yet
    std::uint64_t lost = 0;            ///< samples lost between devices
    std::uint64_t dropped = 0;         ///< samples dropped because the queue was full
    std::uint64_t late = 0;            ///< how often the value became stale
    std::string incompatible{};        ///< the QoS policy that prevents matching, or empty
    bool expects_value = true;         ///< false for events: such a connection is healthy without a value
  };
  std::map<std::string, Device> devices;       ///< for each device, by its name
  std::map<std::string, std::string> modules;  ///< the state of each module ("EXECUTING"), by "device.module"
  std::map<std::size_t, Connection> connections;  ///< for each connection, by its index in Cell::connections
};

/// The reports of the devices of a cell. The keys are the names "device", "device.module" and
/// "device.module.port".
struct ObservedCell {
  struct Port {
    bool matched = false;
    bool safe = false;
    std::optional<Nanoseconds> age{};
    std::uint64_t lost = 0;
    std::uint64_t dropped = 0;
    std::uint64_t late = 0;
    std::string incompatible{};
  };
  std::map<std::string, CellHealth::Device> devices{};
  std::map<std::string, std::string> modules{};
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

/// The rating of a connection. Every report, drawing and page that shows the health of a connection uses it.
enum class Rating {
  good,
  poor,   ///< an expected value is missing, or samples were lost, dropped or late
  bad,    ///< stale, or the reader gets the safe value
  broken  ///< the writer and the reader have not found each other, although both belong to the cell
};
Rating rating_of(const CellHealth::Connection& health);
const char* word_of(Rating rating) noexcept;

/// The health of a connection as text: "NOT MATCHED: reliability", "STALE, 400 ms old, late 2",
/// "degraded, 1.2 ms old, lost 3", "ok, 1.2 ms old", "no other program".
std::string health_text(const CellHealth::Connection& health);

/// Lists the devices, modules and connections as text, with the same width as check_text(). The text ends
/// with a line feed.
std::string graph_text(const model::Cell& cell, const CellHealth& health, Style style);

/// {"cell", "domain", "discovery", "devices": [{"name", "modules": [{"name", "type", "operation", ...}]}],
/// "connections": [{"from", "to", "kind", ...}]}. Times are in ns. Members without a known value are left
/// out. An end outside Takt is null.
nlohmann::ordered_json graph_json(const model::Cell& cell, const CellHealth& health);

/// The entries of the legend: `drawn` gives only those for the elements that are drawn; `whole` gives all
/// entries, for a page that adds the health later.
enum class GraphLegend { drawn, whole };
/// Draws the cell as SVG: a box for each device with its modules and their connected ports, and an arrow for
/// each connection. The drawing has at most kGraphDevices devices, kGraphModules modules per device and
/// kGraphConnections connections; a note counts the rest. Words and line styles show the health, not only
/// colours.
std::string graph_svg(const model::Cell& cell, const CellHealth& health,
                      GraphLegend legend = GraphLegend::drawn);
inline constexpr std::size_t kGraphDevices = 50;
inline constexpr std::size_t kGraphModules = 100;
inline constexpr std::size_t kGraphConnections = 500;

}  // namespace takt::tool
