#include "host_links.hpp"

#include <utility>

namespace takt::host {

Result<void> HostLinks::attach(const std::vector<PortLink>& links) {
  links_ = links;
  for (const PortLink& end : links) {
    if (memories_.count(end.fd) != 0) continue;
    auto memory = os::SharedMemory::attach(os::Fd{end.fd});
    if (!memory) return memory.problems();
    if (!channel::Link::is_link(memory->data(), memory->size())) {
      return fail("another version of Takt created the memory of port '" + end.port + "'",
                  "install takt-node and takt-host of the same version");
    }
    Memory& mine = memories_[end.fd];
    mine.memory = std::move(*memory);
    mine.link = channel::Link{mine.memory.data()};
    // The values of a typed link were in the memory of the former host, and were lost when that host ended.
    if (end.typed) channel::drop_samples(mine.link);
  }
  return {};
}

Result<void> HostLinks::connect(std::uint32_t index, ThreadModule& module) {
  for (const PortLink& end : links_) {
    if (end.module != index) continue;
    PortBase* port = module.port(end.port);
    if (port == nullptr)
      return fail("the component no longer has the port '" + end.port + "'", "deploy the cell again");
    Memory& memory = memories_.at(end.fd);
    if (end.typed && memory.values == nullptr) {
      memory.values = port->make_values(memory.link.buffers());
      memory.value_size = port->value_size();
    }
    if (end.typed && memory.value_size != port->value_size()) {
      return fail("the values of port '" + end.port +
                      "' differ in size from those of the port that it is connected to",
                  "compile both components with the same compiler, from the same IDL file");
    }
    if (!end.typed && memory.link.stride() < port->type().max_size) {
      return fail("the type of port '" + end.port + "' has changed since the node checked the cell",
                  "deploy the cell again");
    }
    port->connect(memory.link, end.typed ? memory.values : nullptr);
    if (port->direction() != PortDirection::out)
      module.check_deadline(memory.link, *port, end.stale_is_error);
  }
  return {};
}

}  // namespace takt::host
