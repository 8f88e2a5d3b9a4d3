// The real-time processes of a device, and what runs in each. One is shared by all executors that have none
// of their own: what crashes there takes its neighbours along for as long as the process needs to start
// again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::model {

struct HostShare {
  std::string name;                       ///< of the executor that has it to itself; empty: it is shared
  std::vector<std::size_t> executors{};   ///< in Device::executors
  std::vector<std::uint32_t> modules{};   ///< thread modules that it loads
  std::vector<std::uint32_t> programs{};  ///< process modules that its executors release
  [[nodiscard]] bool is_own() const noexcept { return !name.empty(); }
};

/// In the order of the device; the shared one comes first, and is there when anything is in it, or nothing
/// has one of its own. Non-real-time thread modules are in it. Pure.
std::vector<HostShare> hosts_of(const Device& device);

}  // namespace takt::model
