#include "udp_channels.hpp"

namespace takt::dds {

UdpChannels::Channel::Channel(os::UdpSocket from, std::size_t largest, Handle handle)
    : socket(std::move(from)), buffer(largest), thread([this, handle = std::move(handle)] {
        while (!ended) {
          if (const auto packet = socket.receive(buffer); packet && !ended)
            handle(*packet, {buffer.data(), packet->size});
        }
      }) {}

UdpChannels::Channel::~Channel() {
  ended = true;
  socket.stop();
  thread.join();
}

void UdpChannels::Channel::join(const Interfaces::List& interfaces) {
  std::set<std::pair<os::Ipv4, int>> wanted;
  for (const os::Ipv4& group : groups) {
    for (const os::InterfaceAddress& each : interfaces) wanted.emplace(group, each.interface);
  }
  for (const auto& [group, interface] : joined) {
    if (!wanted.contains({group, interface})) socket.leave(group, interface);
  }
  // An interface that has just disappeared cannot be joined. The kernel's next notice removes it from the
  // list.
  std::erase_if(wanted, [this](const auto& each) { return !socket.join(each.first, each.second); });
  joined = std::move(wanted);
}

bool UdpChannels::is_open(std::uint16_t port) const {
  const std::lock_guard lock{mutex_};
  return channels_.contains(port);
}

bool UdpChannels::open(const os::UdpOptions& options, std::size_t largest, Handle handle) {
  const std::lock_guard lock{mutex_};
  if (channels_.contains(options.port)) return false;
  auto socket = os::UdpSocket::open(options);
  if (!socket) return false;
  channels_[options.port] = std::make_unique<Channel>(std::move(*socket), largest, std::move(handle));
  if (!options.shared) last_own_port_ = options.port;
  return true;
}

std::uint16_t UdpChannels::port_for_samples() const {
  const std::lock_guard lock{mutex_};
  return last_own_port_;
}

bool UdpChannels::close(std::uint16_t port) {
  std::unique_ptr<Channel> closed;  // it ends after the lock, for which its thread may be waiting
  const std::lock_guard lock{mutex_};
  const auto found = channels_.find(port);
  if (found == channels_.end()) return false;
  closed = std::move(found->second);
  channels_.erase(found);
  return true;
}

void UdpChannels::join(std::uint16_t port, const os::Ipv4& group) {
  const std::lock_guard lock{mutex_};
  const auto found = channels_.find(port);
  if (found == channels_.end()) return;
  found->second->groups.insert(group);
  found->second->join(interfaces_->for_groups());
}

void UdpChannels::follow_interfaces() {
  const std::lock_guard lock{mutex_};
  for (const auto& [port, channel] : channels_) channel->join(interfaces_->for_groups());
}

}  // namespace takt::dds
