// The real-time processes (hosts) of a device, and the executors and modules in each. All executors without
// their own host share one. A crash in the shared host stops all its modules until the host has restarted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::model {

struct HostShare {
  std::string name;                       ///< of the only executor in it; empty: the shared host
  std::vector<std::size_t> executors{};   ///< indices in Device::executors
  std::vector<std::uint32_t> modules{};   ///< indices of the thread modules that it loads
  std::vector<std::uint32_t> programs{};  ///< indices of the process modules that its executors release
  [[nodiscard]] bool is_own() const noexcept { return !name.empty(); }
};

/// The hosts of a device, in the order of its executors, the shared one first. There is a shared host if it
/// contains anything, or if no executor has its own host. Non-real-time thread modules run in it. Pure.
std::vector<HostShare> hosts_of(const Device& device);

}  // namespace takt::model
