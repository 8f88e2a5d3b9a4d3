#include <takt/os/udp_socket.hpp>

#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

#include "error.hpp"

namespace takt::os {

namespace {

in_addr in_addr_of(const Ipv4& numbers) {
  in_addr address{};
  std::memcpy(&address, numbers.data(), numbers.size());
  return address;
}

Ipv4 ipv4_of(const in_addr& address) {
  Ipv4 numbers{};
  std::memcpy(numbers.data(), &address, numbers.size());
  return numbers;
}

ip_mreqn membership(const Ipv4& group, int interface) {
  return {.imr_multiaddr = in_addr_of(group), .imr_address = {}, .imr_ifindex = interface};
}

// Space for the one piece of information about a packet that these sockets send and receive.
union PacketInfo {
  cmsghdr header;
  std::array<char, CMSG_SPACE(sizeof(in_pktinfo))> bytes;
};

}  // namespace

Result<UdpSocket> UdpSocket::open(const UdpOptions& options) {
  Fd fd{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  if (!fd) return errno_problem("socket");
  const int on = 1;
  if (options.shared && ::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0)
    return errno_problem("setsockopt SO_REUSEADDR");
  if (::setsockopt(fd.get(), IPPROTO_IP, IP_PKTINFO, &on, sizeof on) != 0)
    return errno_problem("setsockopt IP_PKTINFO");
  const int comes_back = options.groups_come_back ? 1 : 0;
  if (::setsockopt(fd.get(), IPPROTO_IP, IP_MULTICAST_LOOP, &comes_back, sizeof comes_back) != 0)
    return errno_problem("setsockopt IP_MULTICAST_LOOP");
  if (options.receive_buffer > 0) {
    // The kernel takes less if its limit is lower.
    const int size = static_cast<int>(options.receive_buffer);
    ::setsockopt(fd.get(), SOL_SOCKET, SO_RCVBUF, &size, sizeof size);
  }
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_port = htons(options.port);
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&here), sizeof here) != 0)
    return errno_problem("bind to UDP port " + std::to_string(options.port));
  return UdpSocket{std::move(fd)};
}

bool UdpSocket::join(const Ipv4& group, int interface) noexcept {
  const ip_mreqn wanted = membership(group, interface);
  return ::setsockopt(fd_.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &wanted, sizeof wanted) == 0 ||
         errno == EADDRINUSE;
}

void UdpSocket::leave(const Ipv4& group, int interface) noexcept {
  const ip_mreqn wanted = membership(group, interface);
  ::setsockopt(fd_.get(), IPPROTO_IP, IP_DROP_MEMBERSHIP, &wanted, sizeof wanted);
}

bool UdpSocket::send(std::span<const std::uint8_t> bytes, const UdpEnd& to,
                     const InterfaceAddress* from) noexcept {
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(to.port);
  there.sin_addr = in_addr_of(to.address);
  iovec content{.iov_base = const_cast<std::uint8_t*>(bytes.data()), .iov_len = bytes.size()};
  msghdr message{};
  message.msg_name = &there;
  message.msg_namelen = sizeof there;
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  PacketInfo info{};
  if (from != nullptr) {
    message.msg_control = &info;
    message.msg_controllen = sizeof info;
    cmsghdr* const header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = IPPROTO_IP;
    header->cmsg_type = IP_PKTINFO;
    header->cmsg_len = CMSG_LEN(sizeof(in_pktinfo));
    const in_pktinfo way{
        .ipi_ifindex = from->interface, .ipi_spec_dst = in_addr_of(from->address), .ipi_addr = {}};
    std::memcpy(CMSG_DATA(header), &way, sizeof way);
  }
  return ::sendmsg(fd_.get(), &message, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0 || errno == EAGAIN ||
         errno == EWOULDBLOCK;
}

std::optional<UdpSocket::Received> UdpSocket::receive(std::span<std::uint8_t> buffer) noexcept {
  sockaddr_in from{};
  iovec content{.iov_base = buffer.data(), .iov_len = buffer.size()};
  PacketInfo info{};
  msghdr message{};
  message.msg_name = &from;
  message.msg_namelen = sizeof from;
  message.msg_iov = &content;
  message.msg_iovlen = 1;
  message.msg_control = &info;
  message.msg_controllen = sizeof info;
  const ssize_t n = ::recvmsg(fd_.get(), &message, 0);
  // After stop(), recvmsg() returns 0 and no sender.
  if (n < 0 || message.msg_namelen == 0) return std::nullopt;
  Received received{.size = static_cast<std::size_t>(n),
                    .from = {.address = ipv4_of(from.sin_addr), .port = ntohs(from.sin_port)}};
  for (cmsghdr* each = CMSG_FIRSTHDR(&message); each != nullptr; each = CMSG_NXTHDR(&message, each)) {
    if (each->cmsg_level != IPPROTO_IP || each->cmsg_type != IP_PKTINFO) continue;
    in_pktinfo way{};
    std::memcpy(&way, CMSG_DATA(each), sizeof way);
    received.to = ipv4_of(way.ipi_addr);
    received.interface = way.ipi_ifindex;
  }
  return received;
}

void UdpSocket::stop() noexcept { ::shutdown(fd_.get(), SHUT_RD); }

}  // namespace takt::os
