// Converts the samples that nodes publish to Prometheus metrics, in text format 0.0.4. The names follow
// Prometheus' naming guide: base units, and the suffix _total for counters.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>
#include <takt/wire/cell_state.hpp>

namespace takt::tool::web {

/// The numbers of fault events and open pages, counted by the gateway.
struct Counted {
  /// The number of fault events, by device and severity. A model::Severity is the index of the array.
  std::map<std::string, std::array<std::uint64_t, 3>> faults{};
  std::size_t viewers = 0;  ///< open event streams
};

/// The metrics as text. `cell` is the running cell. If no running cell is known, `cell` is null and the text
/// has no metrics of connections.
std::string metrics_text(const std::vector<wire::ObservedDevice>& devices, const model::Cell* cell,
                         const Counted& counted);

}  // namespace takt::tool::web
