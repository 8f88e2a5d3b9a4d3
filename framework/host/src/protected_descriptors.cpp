#include <bitset>
#include <cstddef>

#include <takt/component/failure.hpp>
#include <takt/host/host.hpp>
#include <takt/os/fd.hpp>
#include "executor_threads.hpp"

namespace takt::host {

namespace {

/// The file descriptors of the host. They do not change once modules are loaded.
std::bitset<65536> own_descriptors;

}  // namespace

void protect_descriptors() {
  for (const int fd : os::open_descriptors()) {
    if (static_cast<std::size_t>(fd) < own_descriptors.size())
      own_descriptors.set(static_cast<std::size_t>(fd));
  }
}

bool protects(int fd) noexcept {
  const auto index = static_cast<std::size_t>(fd);
  if (fd < 0 || index >= own_descriptors.size() || !own_descriptors[index] || !in_module()) return false;
  report_failure(
      "it tried to close file descriptors of the host, which stay open; close only those that the module has "
      "opened");
  return true;
}

}  // namespace takt::host
