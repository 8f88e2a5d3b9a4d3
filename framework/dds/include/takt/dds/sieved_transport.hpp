// UDP without what is no RTPS message, or in the clear where DDS Security is on, one at a time with the
// making of readers. Not for other rooms.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <utility>

#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>

#include <takt/dds/handling.hpp>
#include <takt/dds/newcomers.hpp>
#include <takt/dds/notices.hpp>

namespace takt::dds {

/// What was refused and what is handled, for all transports of a process.
struct Sieve {
  Sieve(Notices& whom, bool with_security) : notices(whom), secured(with_security) {}
  Notices& notices;
  const bool secured;
  Newcomers newcomers;  // with security
  std::atomic<std::uint64_t> refused{0};
  Handling handling;
};

/// Of a transport of Fast DDS, in which whatever comes is held against readable_rtps() first, and with
/// security against is_protected_rtps().
class SievedDescriptor final : public eprosima::fastdds::rtps::ChainingTransportDescriptor {
 public:
  SievedDescriptor(std::shared_ptr<eprosima::fastdds::rtps::TransportDescriptorInterface> below,
                   std::shared_ptr<Sieve> sieve)
      : ChainingTransportDescriptor(std::move(below)), sieve_(std::move(sieve)) {}
  [[nodiscard]] eprosima::fastdds::rtps::TransportInterface* create_transport() const override;

 private:
  std::shared_ptr<Sieve> sieve_;
};

}  // namespace takt::dds
