// The addresses of peers and discovery servers that are given by name.
//
// Fast DDS takes addresses, and takes them only when the participant is created. But when a device starts,
// the name service may not answer yet, or may not know a machine that will only join later, and the address
// of a name may change. So Fast DDS gets a placeholder for each name, and the transport sends what is meant
// for the placeholder to the addresses that the name has at the moment. Only the source files of this room
// include this header.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/os/network.hpp>

namespace takt::dds {

/// Looks up names again and again: every three seconds while a name has no address, or while no packet comes
/// from its addresses, and otherwise every minute. A name keeps its last addresses while the name service
/// does not answer. Any thread may call these functions, except add(). The object must belong to a
/// shared_ptr.
class HostNames : public std::enable_shared_from_this<HostNames> {
 public:
  using LookUp = std::function<void(const std::string& host, const os::FoundAddresses& found)>;
  /// `look_up` may call `found` at any time and on any thread. `tell` gets a sentence about each name that
  /// has no address yet, and about the addresses that it gets later; only step() calls it.
  HostNames(LookUp look_up, std::function<void(const std::string&)> tell)
      : look_up_(std::move(look_up)), tell_(std::move(tell)) {}

  /// Returns the address for Fast DDS: a placeholder, unless the host is an address itself. `role` is the
  /// role of the host, for messages: "peer", for example. Call this function before the first step().
  os::Ipv4 add(const std::string& role, const std::string& host);
  /// Returns a placeholder for a discovery server, also if `host` is an address: what is meant for the server
  /// is then also sent to the addresses that it announces. Call this function before the first step().
  os::Ipv4 add_server(const std::string& host);
  /// Begins to look up the names whose turn it is, and tells what has changed. Call it often.
  void step(Instant now);
  /// The host of this placeholder has announced these addresses. They are used as well as those of its name,
  /// until it announces others.
  void announced(const os::Ipv4& placeholder, const std::vector<os::Ipv4>& addresses);
  /// Notes that a packet has come from this address.
  void heard(const os::Ipv4& address);
  /// Waits until no look-up is under way, but only this long.
  void wait(Nanoseconds limit);

  static bool is_placeholder(const os::Ipv4& address) noexcept;
  /// Returns where to send what is meant for this placeholder; nothing while no address is known.
  [[nodiscard]] std::vector<os::Ipv4> addresses(const os::Ipv4& placeholder) const;
  /// Returns a text about each name that has no address, separated by semicolons.
  [[nodiscard]] std::string unresolved() const;

 private:
  struct Host {
    std::string role_and_name;
    std::string name;  // empty if the host was given by its address
    std::vector<os::Ipv4> addresses{};
    std::vector<os::Ipv4> announced{};
    std::string reason{};  // why the last look-up has failed
    bool under_way = false;
    std::optional<Instant> looked_up{};  // when the last look-up began
    bool heard = false;                  // a packet has come since the last step()
    std::optional<Instant> alive{};      // the last step() that found a packet
    bool warned = false;                 // the last news was that it has no address
    std::vector<os::Ipv4> told{};        // the addresses in the last news
  };
  os::Ipv4 add(Host host);
  void found(std::size_t index, const Result<std::vector<os::Ipv4>>& result);

  const LookUp look_up_;
  const std::function<void(const std::string&)> tell_;
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  std::vector<Host> hosts_;
  std::size_t under_way_ = 0;
};

}  // namespace takt::dds
