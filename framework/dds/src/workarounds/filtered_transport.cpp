#include "filtered_transport.hpp"

#include <cstring>
#include <string>

#include <fastdds/rtps/network/SenderResource.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastrtps/utils/IPLocator.h>

#include <takt/wire/rtps.hpp>
#include <takt/security/identity.hpp>

namespace takt::dds {

namespace {

namespace transport = eprosima::fastdds::rtps;
using eprosima::fastrtps::rtps::IPLocator;
using eprosima::fastrtps::rtps::Locator_t;
using eprosima::fastrtps::rtps::octet;
using eprosima::fastrtps::rtps::SenderResource;

std::uint32_t packed_address_of(const Locator_t& from) {
  std::uint32_t address = 0;
  std::memcpy(&address, IPLocator::getIPv4(from), sizeof address);
  return address;
}

class FilteredTransport final : public transport::ChainingTransport {
 public:
  FilteredTransport(const FilteredTransportDescriptor& descriptor, std::shared_ptr<PacketFilter> filter)
      : ChainingTransport(descriptor), descriptor_(descriptor), filter_(std::move(filter)) {}

  [[nodiscard]] transport::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }

  // Fast DDS sends to a loopback address instead of the machine's own addresses, for example to a discovery server
  // on the same machine. If it has never opened a channel for the loopback address, it aborts the process.
  bool OpenOutputChannel(transport::SendResourceList& channels, const Locator_t& to) override {
    const bool opened = ChainingTransport::OpenOutputChannel(channels, to);
    Locator_t local;
    if (!transform_remote_locator(to, local) || local == to) return opened;
    return ChainingTransport::OpenOutputChannel(channels, local) && opened;
  }

  bool send(SenderResource* below, const octet* bytes, std::uint32_t size, transport::LocatorsIterator* begin,
            transport::LocatorsIterator* end, const std::chrono::steady_clock::time_point& limit) override {
    return filter_->silent || below->send(bytes, size, begin, end, limit);
  }

  void receive(transport::TransportReceiverInterface* above, const octet* bytes, std::uint32_t size,
               const Locator_t& here, const Locator_t& from) override {
    if (filter_->silent) return;
    const std::size_t readable =
        wire::readable_rtps({bytes, size}, filter_->secured ? &security::names_somebody : nullptr);
    if (readable == 0) return drop(from, "it is not a valid RTPS message");
    if (filter_->secured) {
      if (!wire::is_protected_rtps({bytes, readable})) return drop(from, "it is not encrypted");
      const wire::Announcement announcement = wire::announcement_in({bytes, readable});
      if (announcement.of != wire::Announcement::Of::nobody &&
          !filter_->unauthenticated.admit(announcement, packed_address_of(from)))
        return drop(
            from, "it announces an invalid participant, or there are too many unauthenticated participants");
    }
    const auto handle = [&] { above->OnDataReceived(bytes, static_cast<std::uint32_t>(readable), here, from); };
    // Fast DDS must not handle two announcements of a participant at once; see participant_removal.hpp.
    if (wire::concerns_participants({bytes, readable}))
      filter_->receive_lock.handle_alone(handle);
    else
      filter_->receive_lock.handle(handle);
  }

 private:
  void drop(const Locator_t& from, const char* why) {
    filter_->refused.fetch_add(1, std::memory_order_relaxed);
    filter_->notices.tell("dropped a packet from " + IPLocator::toIPv4string(from) + ": " + why);
  }

  FilteredTransportDescriptor descriptor_;
  std::shared_ptr<PacketFilter> filter_;
};

}  // namespace

transport::TransportInterface* FilteredTransportDescriptor::create_transport() const {
  return new FilteredTransport{*this, filter_};
}

}  // namespace takt::dds
