#include "udp_transport.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/udp_socket.hpp>
#include <takt/wire/rtps.hpp>

namespace takt::dds {

namespace {

using rtps::IPLocator;
using rtps::Locator_t;
using rtps::LocatorList_t;
using rtps::LocatorSelectorEntry;
using rtps::LocatorsIterator;
using rtps::octet;

/// The number of participants for which Fast DDS searches on a peer, a machine of which only the address is
/// known.
constexpr std::uint32_t kPeerParticipants = 40;
/// Fast DDS repeats an announcement after 20 ms or later.
constexpr Nanoseconds kAtOnce = std::chrono::milliseconds{10};
constexpr std::size_t kReceiveBuffer = 4 * 1024 * 1024;

/// Returns the message without the empty statistics submessage of 60 bytes that Fast DDS appends to each
/// message, for transports that fill it in. It would be a third of a heartbeat.
std::span<const octet> without_statistics(std::span<const octet> message) {
  constexpr std::array<octet, 60> kEmpty{0x80, 1, 56};
  const std::size_t before = std::max(message.size(), kEmpty.size()) - kEmpty.size();
  return std::ranges::equal(message.subspan(before), kEmpty) ? message.first(before) : message;
}

os::Ipv4 address_of(const Locator_t& locator) {
  os::Ipv4 address{};
  std::copy_n(IPLocator::getIPv4(locator), address.size(), address.begin());
  return address;
}

void set_address(Locator_t& locator, const os::Ipv4& address) {
  IPLocator::setIPv4(locator, address[0], address[1], address[2], address[3]);
}

std::uint16_t port_of(const Locator_t& locator) { return IPLocator::getPhysicalPort(locator); }

bool in_network(const os::InterfaceAddress& of, const os::Ipv4& address) {
  for (std::size_t i = 0; i < address.size(); ++i) {
    if (((address[i] ^ of.address[i]) & of.mask[i]) != 0) return false;
  }
  return true;
}

/// True on a thread that handles a packet from this machine.
thread_local bool handles_packet_from_here = false;

class UdpTransport final : public Transport {
 public:
  explicit UdpTransport(const UdpTransportDescriptor& descriptor)
      : Transport(LOCATOR_KIND_UDPv4),
        descriptor_(descriptor),
        interfaces_(*descriptor.interfaces()),
        filter_(*descriptor.filter()),
        channels_(*descriptor.channels()),
        names_(*descriptor.names()) {}

  bool init() override {
    for (std::size_t i = 0; i < kToMachines + kOthers; ++i) {
      auto socket = os::UdpSocket::open({.groups_come_back = i != kOnlyOut});
      if (!socket) return false;
      out_.push_back(std::move(*socket));
    }
    filter_.send = [this](std::span<const std::uint8_t> packet, const os::UdpEnd& to) {
      static_cast<void>(send(packet, to));
    };
    return true;
  }

  // ---- Which locators

  [[nodiscard]] bool IsLocatorSupported(const Locator_t& locator) const override {
    return locator.kind == kind();
  }
  [[nodiscard]] bool is_locator_allowed(const Locator_t& locator) const override {
    return IsLocatorSupported(locator) && (IPLocator::isMulticast(locator) || IPLocator::isAny(locator) ||
                                           interfaces_.allows(address_of(locator)));
  }
  [[nodiscard]] bool is_local_locator(const Locator_t& locator) const override {
    return interfaces_.is_mine(address_of(locator));
  }
  [[nodiscard]] bool DoInputLocatorsMatch(const Locator_t& left, const Locator_t& right) const override {
    return port_of(left) == port_of(right);
  }
  [[nodiscard]] Locator_t RemoteToMainLocal(const Locator_t& remote) const override {
    Locator_t any{remote};
    any.set_Invalid_Address();
    return any;
  }
  // Participants on this machine communicate over the loopback interface, which never disappears. Somebody on
  // this machine may still announce an address that the machine has just lost.
  bool transform_remote_locator(const Locator_t& remote, Locator_t& result) const override {
    if (!IsLocatorSupported(remote)) return false;
    result = remote;
    if (IPLocator::isMulticast(remote)) return true;
    if ((handles_packet_from_here && !interfaces_.has_server()) || is_local_locator(remote))
      set_address(result, os::kLoopbackAddress);
    return true;
  }
  LocatorList_t NormalizeLocator(const Locator_t& locator) override {
    LocatorList_t list;
    if (!IPLocator::isAny(locator)) {
      list.push_back(locator);
      return list;
    }
    for (const os::Ipv4& address : interfaces_.announced()) {
      Locator_t one{locator};
      set_address(one, address);
      list.push_back(one);
    }
    return list;
  }
  // Sends once to a group if several readers can be reached there, and otherwise to all addresses of each
  // reader.
  void select_locators(rtps::LocatorSelector& selector) const override {
    auto& entries = selector.transport_starts();
    const bool use_groups = interfaces_.groups_reach_others();
    const auto waits_for = [](const LocatorSelectorEntry* entry, const Locator_t& group) {
      return entry->transport_should_process &&
             std::find(entry->multicast.begin(), entry->multicast.end(), group) != entry->multicast.end();
    };
    for (std::size_t i = 0; i < entries.size(); ++i) {
      LocatorSelectorEntry& entry = *entries[i];
      if (!std::exchange(entry.transport_should_process, false)) continue;
      bool found = false;
      for (std::size_t j = 0; j < entry.multicast.size() && !found; ++j) {
        bool shared = entry.unicast.empty();
        for (std::size_t k = i + 1; use_groups && k < entries.size(); ++k) {
          if (!waits_for(entries[k], entry.multicast[j])) continue;
          entries[k]->transport_should_process = false;
          shared = true;
        }
        if (!shared) continue;
        entry.state.multicast.push_back(j);
        found = true;
      }
      for (std::size_t j = 0; j < entry.unicast.size() && entry.state.multicast.empty(); ++j) {
        if (selector.is_selected(entry.unicast[j])) continue;
        entry.state.unicast.push_back(j);
        found = true;
      }
      if (found) selector.select(i);
    }
  }

  void AddDefaultOutputLocator(LocatorList_t& list) override { list.push_back(group_at(0)); }
  bool getDefaultMetatrafficMulticastLocators(LocatorList_t& list, std::uint32_t port) const override {
    list.push_back(group_at(port));
    return true;
  }
  bool getDefaultMetatrafficUnicastLocators(LocatorList_t& list, std::uint32_t port) const override {
    list.push_back(any_at(port));
    return true;
  }
  // When an address has changed, Fast DDS 3 asks for the port again that it wanted first.
  bool getDefaultUnicastLocators(LocatorList_t& list, std::uint32_t port) const override {
    const std::lock_guard lock{ports_mutex_};
    const auto found = opened_instead_.find(port);
    list.push_back(any_at(found == opened_instead_.end() ? port : found->second));
    return true;
  }
  bool fillMetatrafficMulticastLocator(Locator_t& locator, std::uint32_t port) const override {
    return fill(locator, port);
  }
  bool fillMetatrafficUnicastLocator(Locator_t& locator, std::uint32_t port) const override {
    return fill(locator, port);
  }
  bool fillUnicastLocator(Locator_t& locator, std::uint32_t port) const override {
    return fill(locator, port);
  }
  bool configureInitialPeerLocator(Locator_t& peer, const rtps::PortParameters& ports, std::uint32_t domain,
                                   LocatorList_t& list) const override {
    if (peer.port != 0) {
      list.push_back(peer);
      return true;
    }
    for (std::uint32_t i = 0; i < descriptor_.max_initial_peers_range(); ++i) {
      Locator_t one{peer};
      one.port = ports.getUnicastPort(domain, i);
      list.push_back(one);
    }
    return true;
  }
  transport::TransportDescriptorInterface* get_configuration() override { return &descriptor_; }
  [[nodiscard]] std::uint32_t max_recv_buffer_size() const override { return descriptor_.maxMessageSize; }

  // ---- Receiving

  [[nodiscard]] bool IsInputChannelOpen(const Locator_t& locator) const override {
    return IsLocatorSupported(locator) && channels_.is_open(port_of(locator));
  }
  bool OpenInputChannel(const Locator_t& locator, transport::TransportReceiverInterface* above,
                        std::uint32_t largest) override {
    if (!is_locator_allowed(locator)) return false;
    const bool opened = channels_.open(
        {.port = port_of(locator),
         .shared = IPLocator::isMulticast(locator),
         .receive_buffer = kReceiveBuffer},
        largest,
        [this, above, locator](const os::UdpSocket::Received& packet, std::span<std::uint8_t> bytes) {
          receive(*above, locator, packet, bytes);
        });
    if (IPLocator::isMulticast(locator)) {
      channels_.join(port_of(locator), address_of(locator));
    } else {
      const std::lock_guard lock{ports_mutex_};
      if (!opened) {
        taken_.push_back(port_of(locator));
      } else {
        for (const std::uint16_t taken : std::exchange(taken_, {})) opened_instead_[taken] = port_of(locator);
      }
    }
    return opened;
  }
  bool CloseInputChannel(const Locator_t& locator) override { return channels_.close(port_of(locator)); }

  // ---- Sending

  bool OpenOutputChannel(transport::SendResourceList& channels, const Locator_t& to) override {
    if (!IsLocatorSupported(to)) return false;
    if (!channels.empty()) return true;  // one channel leads to all locators
    channels.push_back(std::make_unique<Sender>(
        kind(), [this](std::span<const octet> message, LocatorsIterator& each, const LocatorsIterator& end) {
          bool sent = true;
          for (; each != end; ++each) {
            if (IsLocatorSupported(*each)) sent &= send(without_statistics(message), *each);
          }
          return sent;
        }));
    return true;
  }

 private:
  [[nodiscard]] Locator_t group_at(std::uint32_t port) const {
    Locator_t locator{any_at(port)};
    set_address(locator, kGroup);
    return locator;
  }
  [[nodiscard]] Locator_t any_at(std::uint32_t port) const {
    Locator_t locator;
    locator.kind = kind();
    locator.port = port;
    locator.set_Invalid_Address();
    return locator;
  }
  static bool fill(Locator_t& locator, std::uint32_t port) {
    if (locator.port == 0) locator.port = port;
    return true;
  }

  void receive(transport::TransportReceiverInterface& above, const Locator_t& port,
               const os::UdpSocket::Received& packet, std::span<std::uint8_t> bytes) {
    if (!interfaces_.receives(packet.to, packet.interface)) return;
    const bool here = interfaces_.comes_from_here(packet.from.address);
    if (!is_group(packet.to) && !here) interfaces_.heard_at(packet.to);
    if (!here) names_.heard(packet.from.address);
    Locator_t from{any_at(packet.from.port)};
    set_address(from, packet.from.address);
    const Arrival arrival{.from = packet.from.address, .here = here, .in_group = is_group(packet.to)};
    filter_.pass(bytes, arrival, [&](std::size_t readable) {
      handles_packet_from_here = here;
      above.OnDataReceived(bytes.data(), static_cast<std::uint32_t>(readable), port, from);
    });
  }

  bool send(std::span<const std::uint8_t> bytes, const Locator_t& to) {
    const os::UdpEnd end{.address = address_of(to), .port = port_of(to)};
    if (!HostNames::is_placeholder(end.address)) return send(bytes, end);
    bool sent = true;
    for (const os::Ipv4& each : names_.addresses(end.address)) sent &= send(bytes, {each, end.port});
    return sent;
  }

  bool send(std::span<const std::uint8_t> bytes, const os::UdpEnd& end) {
    if (!is_group(end.address)) {
      const bool here = interfaces_.is_mine(end.address);
      if (filter_.is_silent(here)) return true;
      if (here) return out_[kHere].send(bytes, {.address = os::kLoopbackAddress, .port = end.port});
      const auto way = way_to(end.address);
      return out_[socket_to(end.address)].send(bytes, end, way ? &*way : nullptr);
    }
    if (was_just_sent(bytes)) return true;
    bool sent = true;
    // The kernel also gives a packet to those on this machine that receive the group on the same interface.
    os::UdpSocket& out = out_[filter_.is_silent(true) ? kOnlyOut : kGroups];
    for (const os::InterfaceAddress& each : interfaces_.for_groups()) {
      if (!filter_.is_silent(each.loopback)) sent &= out.send(bytes, end, &each);
    }
    return sent;
  }

  // Fast DDS sends an announcement to the addresses of all known participants, and then at once to those at
  // which unknown ones may be. With multicast, both are the same group.
  static bool was_just_sent(std::span<const std::uint8_t> announcement) {
    thread_local std::vector<std::uint8_t> last;
    thread_local Instant last_at{};
    if (!wire::concerns_participants(announcement)) return false;
    const Instant now = os::now();
    if (now - last_at < kAtOnce && std::ranges::equal(announcement, last)) return true;
    last.assign(announcement.begin(), announcement.end());
    last_at = now;
    return false;
  }

  // Without a list of interfaces to use, the kernel's routes decide.
  [[nodiscard]] std::optional<os::InterfaceAddress> way_to(const os::Ipv4& address) const {
    std::optional<os::InterfaceAddress> way;
    if (!interfaces_.restricted()) return way;
    for (const os::InterfaceAddress& each : interfaces_.used()) {
      if (!each.loopback && (!way || in_network(each, address))) way = each;
    }
    return way;
  }

  UdpTransportDescriptor descriptor_;
  Interfaces& interfaces_;
  PacketFilter& filter_;
  UdpChannels& channels_;
  HostNames& names_;
  mutable std::mutex ports_mutex_;
  std::vector<std::uint16_t> taken_;  // those that Fast DDS has tried one after the other
  std::map<std::uint32_t, std::uint16_t> opened_instead_;  // by the port that was taken
  // While a machine does not answer, packets for it wait in the kernel and fill the buffer of their socket,
  // which then takes no other packet. So each machine has its own socket, unless there are very many.
  static std::size_t socket_to(const os::Ipv4& address) {
    return kOthers + (address[2] * 7U + address[3]) % kToMachines;
  }
  static constexpr std::size_t kHere = 0;     // for participants on this machine
  static constexpr std::size_t kGroups = 1;   // for multicast groups
  static constexpr std::size_t kOnlyOut = 2;  // for multicast groups; nobody on this machine receives it
  static constexpr std::size_t kOthers = 3;   // the number of these
  static constexpr std::size_t kToMachines = 16;
  std::vector<os::UdpSocket> out_;
};

}  // namespace

UdpTransportDescriptor::UdpTransportDescriptor(std::shared_ptr<Interfaces> interfaces,
                                               std::shared_ptr<PacketFilter> filter,
                                               std::shared_ptr<UdpChannels> channels,
                                               std::shared_ptr<HostNames> names)
    : TransportDescriptorInterface(transport::s_maximumMessageSize, kPeerParticipants),
      interfaces_(std::move(interfaces)),
      filter_(std::move(filter)),
      channels_(std::move(channels)),
      names_(std::move(names)) {}

transport::TransportInterface* UdpTransportDescriptor::create_transport() const {
  return new UdpTransport{*this};
}

}  // namespace takt::dds
