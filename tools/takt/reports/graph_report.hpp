// The output of `takt graph`: devices, modules and connections of a cell, and their health if it runs. As
// text, as JSON, and as a drawing.
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

/// The reported health of a running cell. Devices, modules and connections that are missing here have not
/// been reported, and are drawn as in a cell that does not run.
struct CellHealth {
  struct Device {
    bool alive = true;
    std::string text{};  ///< the reason if its health is not good; may be empty
  };
  struct Connection {
    bool matched = true;               ///< both ends have found each other
    bool stale = false;                ///< the value is older than the deadline
    bool safe = false;                 ///< the reader gets the safe value
    std::optional<Nanoseconds> age{};  ///< of the newest value; none: no value yet
    std::uint64_t lost = 0;            ///< samples lost between devices
    std::uint64_t dropped = 0;         ///< samples dropped from a full queue
    std::uint64_t late = 0;            ///< how often the value became stale
    std::string incompatible{};        ///< the QoS policy that prevents matching; empty: none
  };
  std::map<std::string, Device> devices;          ///< by name
  std::map<std::string, std::string> modules;     ///< states as in reports ("EXECUTING"), by "device.module"
  std::map<std::size_t, Connection> connections;  ///< by their index in Cell::connections
};

/// What the devices report about themselves, by name: "device", "device.module", "device.module.port".
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
/// The health of a cell. Devices of other cells are ignored.
CellHealth health_of(const model::Cell& cell, const ObservedCell& observed);
/// The health of one port. `connection`: the connection that ends at the port; null: none, or not known.
/// `end_lost`: the device at one of its ends is lost.
CellHealth::Connection health_of(const ObservedCell::Port& port, const model::Connection* connection,
                                 bool end_lost);

/// The health of a cell from the object of `takt status --json`. Empty if the object has no device of this
/// cell.
CellHealth health_of(const model::Cell& cell, const nlohmann::ordered_json& status);

/// "not matched (reliability)", "STALE, 400 ms old, late 2", "ok, 1.2 ms old, lost 3".
std::string health_text(const CellHealth::Connection& health);

/// Devices, modules and connections as lists, with the same width as check_text(). Ends with a line feed.
std::string graph_text(const model::Cell& cell, const CellHealth& health, Style style);

/// {"cell", "domain", "discovery", "devices": [{"name", "modules": [{"name", "type", "operation", ...}]}],
/// "connections": [{"from", "to", "kind", ...}]}. Times in ns. Members that are not given or not known are
/// left out. An end outside Takt is null.
nlohmann::ordered_json graph_json(const model::Cell& cell, const CellHealth& health);

/// The cell as SVG: a box for each device with its modules and their connected ports, an arrow for each
/// connection. Draws the first kGraphDevices devices with kGraphModules modules each, and the first
/// kGraphConnections connections between them; a note says how many more there are. Words and line styles
/// show the health, not only colours.
std::string graph_svg(const model::Cell& cell, const CellHealth& health);
inline constexpr std::size_t kGraphDevices = 50;
inline constexpr std::size_t kGraphModules = 100;
inline constexpr std::size_t kGraphConnections = 500;

}  // namespace takt::tool
