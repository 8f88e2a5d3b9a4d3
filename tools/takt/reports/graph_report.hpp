// What `takt graph` says of a cell: its devices, their modules, and what goes from port to port; of one that
// runs also how that goes. For a person, for a program, and as a picture.
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

/// What was heard of a cell that runs. What is not in it is not known, and is drawn as in a cell at rest.
struct CellHealth {
  struct Device {
    bool alive = true;
    std::string text{};  ///< why its health is not good; may be empty
  };
  struct Connection {
    bool matched = true;               ///< there is somebody at the other end
    bool stale = false;                ///< its value is older than its deadline
    bool safe = false;                 ///< its reader gets the safe value
    std::optional<Nanoseconds> age{};  ///< of the newest value; none: there is none yet
    std::uint64_t lost = 0;            ///< on the way between devices
    std::uint64_t dropped = 0;         ///< from a full queue
    std::uint64_t late = 0;            ///< times that the value became stale
    std::string incompatible{};        ///< the QoS policy that kept them from matching; empty: none
  };
  std::map<std::string, Device> devices;          ///< by name
  std::map<std::string, std::string> modules;     ///< states in the words of reports, by "device.module"
  std::map<std::size_t, Connection> connections;  ///< by their index in Cell::connections
};

/// What devices say of themselves, by names: "device", "device.module", "device.module.port".
struct HeardCell {
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
/// Devices that are not of this cell are left out.
CellHealth health_of(const model::Cell& cell, const HeardCell& heard);
/// Of one port. `connection`: of the cell, with the port at its end; null: there is none, or it is not known.
/// `end_lost`: the device at one of its ends is.
CellHealth::Connection health_of(const HeardCell::Port& port, const model::Connection* connection,
                                 bool end_lost);

/// Of what `takt status --json` says. Empty where no device of this cell is in it.
CellHealth health_of(const model::Cell& cell, const nlohmann::ordered_json& status);

/// "not matched (reliability)", "STALE, 400 ms old, late 2", "ok, 1.2 ms old, lost 3".
std::string health_text(const CellHealth::Connection& health);

/// Devices, modules and connections as lists, as wide as check_text(). Ends with a line feed.
std::string graph_text(const model::Cell& cell, const CellHealth& health, Style style);

/// {"cell", "domain", "discovery", "devices": [{"name", "modules": [{"name", "type", "operation", ...}]}],
/// "connections": [{"from", "to", "kind", ...}]}. Times in ns. What is not said or not known is not there,
/// but for an end that is not Takt's, which is null.
nlohmann::ordered_json graph_json(const model::Cell& cell, const CellHealth& health);

/// A box a device with its modules and, of their ports, those that connections name; an arrow a connection.
/// Draws the first kGraphDevices devices with kGraphModules modules each, the first kGraphConnections
/// connections between those, and says so where there are more. A health is told by words and by the kind of
/// a line, and also by colour.
std::string graph_svg(const model::Cell& cell, const CellHealth& health);
inline constexpr std::size_t kGraphDevices = 50;
inline constexpr std::size_t kGraphModules = 100;
inline constexpr std::size_t kGraphConnections = 500;

}  // namespace takt::tool
