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

/// The health of a running cell, from the reports of its devices. A device, module or connection that is
/// missing here has not been reported, and is drawn as if the cell were not running.
struct CellHealth {
  struct Device {
    bool alive = true;
    std::string text{};  ///< the reason if the device's health is not good, or empty
  };
  struct Connection {
    bool matched = true;               ///< the writer and the reader have found each other
    bool stale = false;                ///< the newest value is older than the deadline
    bool safe = false;                 ///< the reader gets the safe value now
    std::optional<Nanoseconds> age{};  ///< the age of the newest value; none if there is no value yet
    std::uint64_t lost = 0;            ///< samples lost between devices
    std::uint64_t dropped = 0;         ///< samples dropped because the queue was full
    std::uint64_t late = 0;            ///< how often the value became stale
    std::string incompatible{};        ///< the QoS policy that prevents matching, or empty
  };
  std::map<std::string, Device> devices;       ///< by name
  std::map<std::string, std::string> modules;  ///< the state of each module ("EXECUTING"), by "device.module"
  std::map<std::size_t, Connection> connections;  ///< by the index in Cell::connections
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
/// The health of the connection at one port. `connection` ends at the port; it is null if there is none or if
/// it is not known. `end_lost` is true if the device at either end of the connection is lost.
CellHealth::Connection health_of(const ObservedCell::Port& port, const model::Connection* connection,
                                 bool end_lost);

/// The health of a cell, from the object that `takt status --json` prints. Empty if the object has no device
/// of this cell.
CellHealth health_of(const model::Cell& cell, const nlohmann::ordered_json& status);

/// The health of a connection as text: "NOT MATCHED: reliability", "STALE, 400 ms old, late 2", "ok, 1.2 ms
/// old, lost 3".
std::string health_text(const CellHealth::Connection& health);

/// Lists the devices, modules and connections as text, with the same width as check_text(). The text ends
/// with a line feed.
std::string graph_text(const model::Cell& cell, const CellHealth& health, Style style);

/// {"cell", "domain", "discovery", "devices": [{"name", "modules": [{"name", "type", "operation", ...}]}],
/// "connections": [{"from", "to", "kind", ...}]}. Times are in ns. Members without a known value are left
/// out. An end outside Takt is null.
nlohmann::ordered_json graph_json(const model::Cell& cell, const CellHealth& health);

/// Draws the cell as SVG: a box for each device with its modules and their connected ports, and an arrow for
/// each connection. It has at most kGraphDevices devices, kGraphModules modules per device and
/// kGraphConnections connections; a note counts the rest. Words and line styles show the health, not only
/// colours.
std::string graph_svg(const model::Cell& cell, const CellHealth& health);
inline constexpr std::size_t kGraphDevices = 50;
inline constexpr std::size_t kGraphModules = 100;
inline constexpr std::size_t kGraphConnections = 500;

}  // namespace takt::tool
