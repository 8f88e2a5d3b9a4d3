// Writes what nodes publish as metrics for Prometheus, in its text format 0.0.4. The names follow the guide
// of Prometheus: base units, and _total for counters.
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

/// The events and pages that the gateway has counted.
struct Counted {
  /// Events of the fault records, by device and severity (index: model::Severity).
  std::map<std::string, std::array<std::uint64_t, 3>> faults{};
  std::size_t viewers = 0;  ///< open pages
};

/// `cell`: the running cell. Null if it is not known; then there are no metrics of connections.
std::string metrics_text(const std::vector<wire::ObservedDevice>& devices, const model::Cell* cell,
                         const Counted& counted);

}  // namespace takt::tool::web
