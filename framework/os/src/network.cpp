#include <takt/os/network.hpp>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <system_error>
#include <thread>

#include "error.hpp"

namespace takt::os {

namespace {

Ipv4 numbers_of(const sockaddr* address) {
  Ipv4 numbers{};
  if (address != nullptr) {
    std::memcpy(numbers.data(), &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, numbers.size());
  }
  return numbers;
}

Result<std::vector<Ipv4>> addresses_of(const std::string& host) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), nullptr, &wanted, &found); error != 0)
    return fail(gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner{found, &freeaddrinfo};
  std::vector<Ipv4> addresses;
  for (const addrinfo* each = found; each != nullptr; each = each->ai_next)
    addresses.push_back(numbers_of(each->ai_addr));
  return addresses;
}

}  // namespace

std::string in_dots(const Ipv4& address) {
  std::string text;
  for (const std::uint8_t number : address) text += (text.empty() ? "" : ".") + std::to_string(number);
  return text;
}

Result<std::vector<InterfaceAddress>> interface_addresses() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return errno_problem("getifaddrs");
  const std::unique_ptr<ifaddrs, decltype(&freeifaddrs)> owner{all, &freeifaddrs};
  std::vector<InterfaceAddress> addresses;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET) continue;
    constexpr unsigned kConnected = IFF_UP | IFF_RUNNING;
    const unsigned interface = if_nametoindex(each->ifa_name);
    if (interface == 0) continue;  // it has disappeared since getifaddrs(), or its label is not its name
    addresses.push_back({.interface = static_cast<int>(interface),
                         .address = numbers_of(each->ifa_addr),
                         .mask = numbers_of(each->ifa_netmask),
                         .connected = (each->ifa_flags & kConnected) == kConnected,
                         .loopback = (each->ifa_flags & IFF_LOOPBACK) != 0});
  }
  return addresses;
}

Result<InterfaceNews> InterfaceNews::open() {
  Fd fd{::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, NETLINK_ROUTE)};
  sockaddr_nl wanted{};
  wanted.nl_family = AF_NETLINK;
  wanted.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
  if (!fd || ::bind(fd.get(), reinterpret_cast<const sockaddr*>(&wanted), sizeof wanted) != 0)
    return errno_problem("netlink socket");
  return InterfaceNews{std::move(fd)};
}

bool InterfaceNews::take() const noexcept {
  std::array<char, 16384> notices{};
  for (bool changed = false;; changed = true) {
    const ssize_t n = ::recv(fd_.get(), notices.data(), notices.size(), 0);
    if (n < 0 && errno != EINTR && errno != ENOBUFS) return changed;  // ENOBUFS: the kernel has lost notices
  }
}

std::optional<Ipv4> from_dots(const std::string& text) {
  in_addr address{};
  if (::inet_pton(AF_INET, text.c_str(), &address) != 1) return std::nullopt;
  Ipv4 numbers{};
  std::memcpy(numbers.data(), &address, numbers.size());
  return numbers;
}

void look_up(std::string host, FoundAddresses found) {
  const auto run = [host = std::move(host), found] { found(addresses_of(host)); };
  try {
    std::thread{run}.detach();
  } catch (const std::system_error& error) {
    found(fail(std::string{"no thread to look it up: "} + error.what()));
  }
}

}  // namespace takt::os
