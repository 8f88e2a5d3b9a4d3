// Connects a client to a service with the same kind of links as the host creates.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <takt/component.hpp>

namespace takt {

/// A link between two ports, with its memory and, if samples are passed as objects, with the objects.
class TestLink {
 public:
  TestLink(PortBase& from, PortBase& to, bool as_objects, std::uint32_t depth = 8,
           std::uint32_t wake_bits = 0) {
    const channel::Link::Options options{.depth = depth,
                                         .payload = as_objects ? 0 : from.type().max_size,
                                         .is_queue = true,
                                         .wake_bits = wake_bits};
    memory_.resize(channel::Link::layout(options).size() / sizeof(Line));
    auto* start = reinterpret_cast<std::byte*>(memory_.data());
    channel::Link::format(start, options);
    link = channel::Link{start};
    void* values = as_objects ? from.make_values(link.buffers()) : nullptr;
    // As in the host, the objects are never freed. This list keeps them reachable, so that the leak checker
    // does not report them.
    static auto& kept = *new std::vector<void*>;
    kept.push_back(values);
    from.connect(link, values);
    to.connect(link, values);
  }
  channel::Link link;

 private:
  struct alignas(64) Line {
    std::array<std::byte, 64> bytes;
  };
  std::vector<Line> memory_;
};

inline PortBase& port_of(const Component& component, const std::string& name) {
  for (PortBase* port : component.ports()) {
    if (port->name() == name) return *port;
  }
  TAKT_CHECK(false);
}

/// A component whose run() does nothing.
struct Plain : Component {
  void run(const Cycle&) override {}
};

template <class T>
struct Asking : Plain {
  Client<T, T> ask{*this, "ask"};
};

/// Connects the client "ask" of one module to the service `name` of another module.
struct ConnectedService {
  ConnectedService(Component& client, Component& server, const std::string& name, bool as_objects,
                   std::uint32_t wake_bits = 0)
      : requests(port_of(client, "ask/request"), port_of(server, name + "/request"), as_objects, 8,
                 wake_bits),
        replies(port_of(server, name + "/reply"), port_of(client, "ask/reply"), as_objects) {}
  TestLink requests;
  TestLink replies;
};

inline void serve_all(Component& component, const PortContext& context) {
  for (PortBase* port : component.ports()) port->serve(context);
}

}  // namespace takt
