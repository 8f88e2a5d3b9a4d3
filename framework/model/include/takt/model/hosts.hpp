// The real-time processes (hosts) of a device, and the executors and modules of each host. All executors
// without their own host share one host. A crash in the shared host stops all its modules until the host has
// restarted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::model {

struct HostShare {
  std::string name;                       ///< the name of the host's only executor; empty for the shared host
  std::vector<std::size_t> executors{};   ///< indices into Device::executors
  std::vector<std::uint32_t> modules{};   ///< indices of the thread modules that the host loads
  std::vector<std::uint32_t> programs{};  ///< indices of the process modules that the host's executors
                                          ///< release
  [[nodiscard]] bool is_own() const noexcept { return !name.empty(); }
};

/// Returns the hosts of a device: first the shared host, then the hosts of single executors, in the order of
/// the executors. There is a shared host if a module or executor belongs to it, or if no executor has its own
/// host. The non-real thread modules belong to the shared host.
std::vector<HostShare> hosts_of(const Device& device);

}  // namespace takt::model
