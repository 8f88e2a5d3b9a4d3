// The links of a host's modules: their memory, and the values of those that carry values.
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
  /// Maps the memory that the node made. Once, before any module is loaded.
  Result<void> attach(const std::vector<PortLink>& links);
  /// Ties the ports of a module that was just loaded to its links. Again when it was loaded again: it goes on
  /// where its former instance was. Fails when it has not the ports that it is to have.
  Result<void> connect(std::uint32_t index, ThreadModule& module);

 private:
  struct Memory {
    os::SharedMemory memory;
    channel::Link link;
    void* values = nullptr;      // for ever: whoever reads one may be anywhere
    std::size_t value_size = 0;  // as the end that made them has it
  };
  std::map<int, Memory> memories_;  // by descriptor
  std::vector<PortLink> links_;
};

}  // namespace takt::host
