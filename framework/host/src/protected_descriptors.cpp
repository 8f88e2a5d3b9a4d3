#include <array>
#include <atomic>
#include <cstddef>

#include <takt/component/failure.hpp>
#include <takt/host/host.hpp>
#include <takt/os/fd.hpp>
#include "executor_threads.hpp"

namespace takt::host {

namespace {

/// The file descriptors of the host: those that were open before the first module was loaded, and that the
/// host has not closed since.
std::array<std::atomic<bool>, 65536> own_descriptors{};

}  // namespace

void protect_descriptors() {
  for (const int fd : os::open_descriptors()) {
    if (const auto index = static_cast<std::size_t>(fd); index < own_descriptors.size())
      own_descriptors[index] = true;
  }
}

bool protects(int fd) noexcept {
  const auto index = static_cast<std::size_t>(fd);
  if (fd < 0 || index >= own_descriptors.size() || !own_descriptors[index]) return false;
  if (!in_module()) {  // a module may get the number next
    own_descriptors[index] = false;
    return false;
  }
  report_failure(
      "it tried to close file descriptors of the host, which stay open; close only those that the module has "
      "opened");
  return true;
}

}  // namespace takt::host
