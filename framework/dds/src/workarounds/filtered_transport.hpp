// A UDP transport that drops packets that are not valid RTPS messages. With DDS Security, it also drops
// packets that are not encrypted, and announcements of unauthenticated participants above the limits. While a
// reader is created or deleted, the transport handles no packet. Only the source files of this room include
// this header.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include <takt/wire/notices.hpp>
#include "receive_lock.hpp"
#include <takt/wire/unauthenticated_participants.hpp>

namespace takt::dds {

/// The state of the packet filter, which all transports of a process share.
struct PacketFilter {
  PacketFilter(wire::Notices& reports, bool with_security) : notices(reports), secured(with_security) {}
  wire::Notices& notices;
  const bool secured;
  wire::UnauthenticatedParticipants unauthenticated;  // used only with DDS Security
  std::atomic<std::uint64_t> refused{0};
  std::atomic<bool> silent{false};  // if true, nothing is sent or received
  ReceiveLock receive_lock;
};

/// Creates a transport for Fast DDS that checks each packet with wire::readable_rtps(), and with DDS Security
/// also with wire::is_protected_rtps().
class FilteredTransportDescriptor final : public eprosima::fastdds::rtps::ChainingTransportDescriptor {
 public:
  FilteredTransportDescriptor(std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> below,
                              std::shared_ptr<PacketFilter> filter)
      : ChainingTransportDescriptor(std::move(below)), filter_(std::move(filter)) {}
  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

 private:
  std::shared_ptr<PacketFilter> filter_;
};

}  // namespace takt::dds
