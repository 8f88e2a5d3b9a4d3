// Carries the messages of Fast DDS in UDP packets over IPv4. The UDP transport of Fast DDS 2.9.1 reads the
// list of interfaces at the start: it loses an interface that is removed and created again, such as a USB
// adapter, and an address that changes. It ends the process if it is to send to an address for which it has
// not prepared. This transport uses the interfaces that exist when it sends, and leaves the rest to the
// kernel. Only the source files of this room include this header.
#pragma once

#include <cstdint>
#include <memory>

#include "fast_dds.hpp"
#include "host_names.hpp"
#include "interfaces.hpp"
#include "packet_filter.hpp"
#include "udp_channels.hpp"

namespace takt::dds {

/// Creates the transport of the participant.
class UdpTransportDescriptor final : public transport::TransportDescriptorInterface {
 public:
  UdpTransportDescriptor(std::shared_ptr<Interfaces> interfaces, std::shared_ptr<PacketFilter> filter,
                         std::shared_ptr<UdpChannels> channels, std::shared_ptr<HostNames> names);
  [[nodiscard]] transport::TransportInterface* create_transport() const override;
  [[nodiscard]] std::uint32_t min_send_buffer_size() const override { return maxMessageSize; }

  [[nodiscard]] const std::shared_ptr<Interfaces>& interfaces() const noexcept { return interfaces_; }
  [[nodiscard]] const std::shared_ptr<PacketFilter>& filter() const noexcept { return filter_; }
  [[nodiscard]] const std::shared_ptr<UdpChannels>& channels() const noexcept { return channels_; }
  [[nodiscard]] const std::shared_ptr<HostNames>& names() const noexcept { return names_; }

 private:
  std::shared_ptr<Interfaces> interfaces_;
  std::shared_ptr<PacketFilter> filter_;
  std::shared_ptr<UdpChannels> channels_;
  std::shared_ptr<HostNames> names_;
};

}  // namespace takt::dds
