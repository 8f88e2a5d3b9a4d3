// The ports on which the participant receives packets. Only the source files of this room include this
// header.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include <takt/os/udp_socket.hpp>
#include "interfaces.hpp"

namespace takt::dds {

/// Receives the packets of each open port on a thread of its own. The threads inherit the scheduling policy
/// of the thread that opens the port. Any thread may call these functions, except a handler close().
class UdpChannels {
 public:
  /// Gets each packet of a port. The bytes are valid only during the call.
  using Handle = std::function<void(const os::UdpSocket::Received&, std::span<std::uint8_t>)>;

  explicit UdpChannels(std::shared_ptr<const Interfaces> interfaces) : interfaces_(std::move(interfaces)) {}

  [[nodiscard]] bool is_open(std::uint16_t port) const;
  /// Opens a port for packets of up to `largest` bytes. Returns false if it is open already, or cannot be
  /// opened.
  bool open(const os::UdpOptions& options, std::size_t largest, Handle handle);
  /// When this function has returned, the handler is not called any more. Returns false if the port is not
  /// open.
  bool close(std::uint16_t port);
  /// Returns the port on which the participant receives samples: its last port that is not shared. Fast DDS
  /// opens the ports for discovery first.
  [[nodiscard]] std::uint16_t port_for_samples() const;
  /// Receives what is sent to this multicast group, if the port is open.
  void join(std::uint16_t port, const os::Ipv4& group);
  /// Receives the groups on the interfaces that are used now, and not on others.
  void follow_interfaces();

 private:
  struct Channel {
    Channel(os::UdpSocket from, std::size_t largest, Handle handle);
    ~Channel();
    Channel(const Channel&) = delete;
    Channel& operator=(const Channel&) = delete;
    void join(const Interfaces::List& interfaces);

    os::UdpSocket socket;
    std::vector<std::uint8_t> buffer;
    std::set<os::Ipv4> groups;
    std::set<std::pair<os::Ipv4, int>> joined;  // group and interface
    std::atomic<bool> ended{false};
    std::thread thread;  // the last member, because it uses the others
  };

  const std::shared_ptr<const Interfaces> interfaces_;
  mutable std::mutex mutex_;
  std::map<std::uint16_t, std::unique_ptr<Channel>> channels_;
  std::uint16_t last_own_port_ = 0;
};

}  // namespace takt::dds
