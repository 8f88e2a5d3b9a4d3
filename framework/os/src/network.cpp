#include <takt/os/network.hpp>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <memory>

#include "error.hpp"

namespace takt::os {

namespace {

std::string in_dots(const sockaddr* address) {
  std::array<char, INET_ADDRSTRLEN> text{};
  const auto* in = reinterpret_cast<const sockaddr_in*>(address);
  return inet_ntop(AF_INET, &in->sin_addr, text.data(), text.size()) == nullptr ? "" : text.data();
}

}  // namespace

Result<std::vector<std::string>> ipv4_addresses() {
  ifaddrs* all = nullptr;
  if (getifaddrs(&all) != 0) return errno_problem("getifaddrs");
  std::vector<std::string> addresses;
  for (const ifaddrs* each = all; each != nullptr; each = each->ifa_next) {
    constexpr unsigned kUsable = IFF_UP | IFF_RUNNING;
    if (each->ifa_addr == nullptr || each->ifa_addr->sa_family != AF_INET ||
        (each->ifa_flags & kUsable) != kUsable) {
      continue;
    }
    addresses.push_back(in_dots(each->ifa_addr));
  }
  freeifaddrs(all);
  return addresses;
}

Result<std::string> resolve_ipv4(const std::string& host) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), nullptr, &wanted, &found); error != 0) {
    return fail("the host '" + host + "' has no IPv4 address: " + gai_strerror(error),
                "give a host name that this machine can look up, or an IPv4 address");
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner{found, &freeaddrinfo};
  return in_dots(found->ai_addr);
}

}  // namespace takt::os
