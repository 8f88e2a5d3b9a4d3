// The channel of one device: one block for each host, each executor and each module, in one piece of shared
// memory. The node creates the channel and keeps it when a host restarts, so that counters continue.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/channel/layout.hpp>
#include <takt/core/result.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel {

class Channel {
 public:
  Channel() = default;
  static Result<Channel> create(std::size_t hosts, const std::vector<std::string>& executors,
                                const std::vector<std::string>& modules);
  /// Opens the channel that another process created. Fails if the memory is not a channel, or if another
  /// version of Takt created it.
  static Result<Channel> attach(os::Fd fd);

  /// Returns the block of a host. `index` must be below hosts().
  [[nodiscard]] HostBlock& host(std::size_t index) const noexcept;
  /// Returns the block of an executor. `index` must be below executors().
  [[nodiscard]] ExecutorBlock& executor(std::size_t index) const noexcept;
  /// Returns the block of a module. `index` must be below modules().
  [[nodiscard]] ModuleBlock& module(std::size_t index) const noexcept;
  [[nodiscard]] std::size_t hosts() const noexcept { return hosts_; }
  [[nodiscard]] std::size_t executors() const noexcept { return executors_; }
  [[nodiscard]] std::size_t modules() const noexcept { return modules_; }
  [[nodiscard]] const os::Fd& fd() const noexcept { return memory_.fd(); }

 private:
  os::SharedMemory memory_;
  std::size_t hosts_ = 0;
  std::size_t executors_ = 0;
  std::size_t modules_ = 0;
};

}  // namespace takt::channel
