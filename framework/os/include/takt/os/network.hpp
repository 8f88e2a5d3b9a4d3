// The network interfaces of this machine, their changes, and name lookup.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// The four numbers of an IPv4 address.
using Ipv4 = std::array<std::uint8_t, 4>;

inline constexpr Ipv4 kLoopbackAddress{127, 0, 0, 1};

/// Returns an address in the usual form, for example "10.0.0.7".
std::string in_dots(const Ipv4& address);

/// One IPv4 address of a network interface. An interface with several addresses has several of these.
struct InterfaceAddress {
  int interface =
      0;  ///< the kernel's number of the interface; a removed interface never gets its number back
  Ipv4 address{};
  Ipv4 mask{};             ///< the bits of the address that are the same for the whole network
  bool connected = false;  ///< the interface is up, and a cable is plugged in, or the like
  bool loopback = false;
  bool operator==(const InterfaceAddress&) const = default;
};

/// Returns the IPv4 addresses of all interfaces, in the system's order. Fails if a system call fails, for
/// example because this process cannot open another file descriptor.
Result<std::vector<InterfaceAddress>> interface_addresses();

/// Tells that an interface or an address of this machine has appeared, changed or disappeared (rtnetlink(7)).
class InterfaceNews {
 public:
  /// Fails if a system call fails.
  static Result<InterfaceNews> open();

  /// Returns true if something has changed since the last call, or if the kernel has lost a notice. Never
  /// waits.
  bool take() const noexcept;
  /// Readable while take() would return true.
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  explicit InterfaceNews(Fd fd) noexcept : fd_(std::move(fd)) {}
  Fd fd_;
};

/// Reads an address that in_dots() has written; empty if the text is something else.
std::optional<Ipv4> from_dots(const std::string& text);

/// Gets the IPv4 addresses of a host name, at least one. If there are none, the problem says why.
using FoundAddresses = std::function<void(const Result<std::vector<Ipv4>>&)>;
/// Looks up a host name on a thread of its own, because the name service may need a minute to answer, and
/// calls `found` there. The thread may run until the process ends, so `found` must not use what may end
/// before.
void look_up(std::string host, FoundAddresses found);

}  // namespace takt::os
