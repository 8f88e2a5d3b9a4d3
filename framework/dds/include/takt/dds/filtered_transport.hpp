// UDP without what is no RTPS message, or in the clear where DDS Security is on, one at a time with the
// making of readers. Not for other rooms.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include <takt/dds/notices.hpp>
#include <takt/dds/receive_lock.hpp>
#include <takt/dds/unauthenticated_participants.hpp>

namespace takt::dds {

/// What was refused and what is handled, for all transports of a process.
struct PacketFilter {
  PacketFilter(Notices& whom, bool with_security) : notices(whom), secured(with_security) {}
  Notices& notices;
  const bool secured;
  UnauthenticatedParticipants unauthenticated;  // with security
  std::atomic<std::uint64_t> refused{0};
  ReceiveLock receive_lock;
};

/// Of a transport of Fast DDS, in which whatever comes is held against readable_rtps() first, and with
/// security against is_protected_rtps().
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
