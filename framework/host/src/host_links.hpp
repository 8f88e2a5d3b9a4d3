// The links of a host's modules: their memory, and the values of typed links.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/core/result.hpp>
#include <takt/host/protocol.hpp>
#include <takt/host/thread_module.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::host {

class HostLinks {
 public:
  /// Maps the links' memory, which the node made. Call it once, before any module is loaded.
  Result<void> attach(const std::vector<PortLink>& links);
  /// Connects the ports of a newly loaded module to its links. A reloaded module continues at the link
  /// positions of its former instance. Fails if a port is missing or has changed since the node checked the
  /// cell.
  Result<void> connect(std::uint32_t index, ThreadModule& module);

 private:
  struct Memory {
    os::SharedMemory memory;
    channel::Link link;
    void* values = nullptr;      // never freed: a reader may be using one at any time
    std::size_t value_size = 0;  // size of one value, as the port that created the values reports it
  };
  std::map<int, Memory> memories_;  // by descriptor
  std::vector<PortLink> links_;
};

}  // namespace takt::host
