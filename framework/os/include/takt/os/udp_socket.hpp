// A UDP socket for IPv4 that chooses the interface of each packet that it sends, and tells how each packet
// came.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>
#include <takt/os/network.hpp>

namespace takt::os {

struct UdpOptions {
  std::uint16_t port = 0;          ///< on all addresses of this machine; 0 for any free port
  bool shared = false;             ///< other sockets may use the port, too, as for multicast
  std::size_t receive_buffer = 0;  ///< in bytes; 0 for the system's default
  bool groups_come_back =
      true;  ///< sockets of this machine also receive what this one sends to a multicast group
};

struct UdpEnd {
  Ipv4 address{};
  std::uint16_t port = 0;
};

/// Any thread may call send(), join() and leave() while another one waits in receive().
class UdpSocket {
 public:
  /// Fails if the port is in use, or if a system call fails.
  static Result<UdpSocket> open(const UdpOptions& options);

  /// Begins to receive what is sent to a multicast group on this interface. Returns false if that is
  /// impossible, for example because the interface is gone. Returns true if the socket receives it already.
  bool join(const Ipv4& group, int interface) noexcept;
  /// Ends what join() began; nothing happens if there is nothing to end. The interface may be gone.
  void leave(const Ipv4& group, int interface) noexcept;

  /// Sends a packet without waiting: if the network takes no packet now, it is lost. `from` is the interface
  /// and the address of the sender; without it, the kernel chooses both. Returns false if the packet cannot
  /// be sent.
  bool send(std::span<const std::uint8_t> bytes, const UdpEnd& to,
            const InterfaceAddress* from = nullptr) noexcept;

  struct Received {
    std::size_t size = 0;
    UdpEnd from;
    Ipv4 to{};          ///< the address to which the packet was sent; a multicast group, for example
    int interface = 0;  ///< where the packet came in; for a packet from this machine, where it went out
  };
  /// Waits for a packet. A packet that is larger than the buffer is cut off. Returns nothing if the socket
  /// has been stopped, or if waiting has failed.
  std::optional<Received> receive(std::span<std::uint8_t> buffer) noexcept;
  /// From now on, receive() returns nothing, also where it waits at this moment.
  void stop() noexcept;

 private:
  explicit UdpSocket(Fd fd) noexcept : fd_(std::move(fd)) {}
  Fd fd_;
};

}  // namespace takt::os
