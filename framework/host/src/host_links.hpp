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
  /// Maps the memory of the links, which the node has created. Call this once, before any module is loaded.
  Result<void> attach(const std::vector<PortLink>& links);
  /// Connects the ports of a newly loaded module to its links. The ports continue at the link positions of
  /// the module's former instance. Fails if a port is missing or has changed since the node checked the cell.
  Result<void> connect(std::uint32_t index, ThreadModule& module);

 private:
  struct Memory {
    os::SharedMemory memory;
    channel::Link link;
    void* values = nullptr;      // never freed, because a reader may be using a value at any time
    std::size_t value_size = 0;  // size of one value, as the port that created the values reports it
  };
  std::map<int, Memory> memories_;  // by file descriptor
  std::vector<PortLink> links_;
};

}  // namespace takt::host
