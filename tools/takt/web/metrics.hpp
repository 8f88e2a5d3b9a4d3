// What nodes say, for Prometheus: its text format 0.0.4, with names as its guide has them (base units, _total
// for what only grows).
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/dds/cell_state.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>

namespace takt::tool::web {

/// What the gateway has counted since it began.
struct Counted {
  /// Events of the fault records, by device and severity (the place of model::Severity).
  std::map<std::string, std::array<std::uint64_t, 3>> faults{};
  std::size_t viewers = 0;  ///< pages that are open
};

/// `cell`: what runs; null: not known, and nothing is said of connections.
std::string metrics_text(const std::vector<dds::ObservedDevice>& devices, const model::Cell* cell,
                         const Counted& counted);

}  // namespace takt::tool::web
