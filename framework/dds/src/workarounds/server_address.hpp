// Lets a client follow its discovery server to another address. Only the source files of this room include
// this header.
//
// A client of Fast DDS 2.9.1 announces itself to the address of the server that it was given, but
// acknowledges and requests at the addresses that the server announced last. If the server's machine gets
// another address, or if the server is started again on another machine, the client learns the new addresses
// from the server, but does not use them.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <takt/os/network.hpp>
#include "../fast_dds.hpp"

namespace takt::dds {

struct NamedServer {
  rtps::GuidPrefix_t prefix;
  rtps::Locator_t locator;                                      ///< of a placeholder; see HostNames
  std::function<void(const std::vector<os::Ipv4>&)> announced;  ///< called with each announcement's addresses
};

/// The participant of this process sends all discovery messages for this server to this locator, whatever the
/// server announces. Ends the process if the function of Fast DDS that server_address.cpp replaces is
/// missing. Call this function before the participant is created.
void reach_server_at(std::optional<NamedServer> server);

}  // namespace takt::dds
