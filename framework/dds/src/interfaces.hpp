// The addresses of this machine that the participant uses. Only the source files of this room include this
// header.
#pragma once

#include <mutex>
#include <set>
#include <utility>
#include <vector>

#include <takt/os/network.hpp>

namespace takt::dds {

/// The multicast group of DDS (RTPS 2.5, 9.6.2.1).
inline constexpr os::Ipv4 kGroup{239, 255, 0, 1};

/// Returns true if this is the address of a multicast group.
bool is_group(const os::Ipv4& address) noexcept;

/// Follows the addresses of this machine. Any thread may call these functions.
///
/// The participant uses an address from the moment when its interface is connected (it is up, and a cable is
/// plugged in) until the address is removed. A pulled cable changes nothing: usually it is plugged in again,
/// and until then a changed list would only cost messages.
class Interfaces {
 public:
  struct Options {
    std::vector<os::Ipv4>
        only;  ///< the addresses to use, besides those of the loopback interface; empty for all
    bool groups_stay_here = false;  ///< send to multicast groups only on this machine
    bool has_server = false;        ///< a discovery server passes the announcements of others on
  };
  explicit Interfaces(Options options) : options_(std::move(options)) {}

  using List = std::vector<os::InterfaceAddress>;

  struct Change {
    bool any = false;
    bool added = false;
    bool removed_used = false;  ///< an address has disappeared to which another machine has sent something
  };
  /// Takes the addresses that the kernel lists now. for_groups() returns those from before until settle() is
  /// called, because an interface must not be used before the participant announces its address: who gets an
  /// announcement without the address keeps it for ever.
  Change update(const List& known_to_kernel);
  void settle();

  /// Returns the addresses that the participant uses.
  [[nodiscard]] List used() const;
  /// Returns those on which it sends to multicast groups and receives from them, one for each interface.
  [[nodiscard]] List for_groups() const;
  [[nodiscard]] bool has_server() const noexcept { return options_.has_server; }
  /// Returns true if other machines receive what is sent to a multicast group.
  [[nodiscard]] bool groups_reach_others() const noexcept {
    return !options_.groups_stay_here && !options_.has_server;
  }
  /// Returns true if the participant must not use all addresses.
  [[nodiscard]] bool restricted() const noexcept { return !options_.only.empty(); }
  /// Returns the addresses that other machines can use to reach this participant, or only 127.0.0.1 if there
  /// is none.
  [[nodiscard]] std::vector<os::Ipv4> announced() const;
  /// Returns true if this is an address of this machine, whether the participant uses it or not.
  /// Also if the machine has lost it: participants of this machine may still announce it.
  [[nodiscard]] bool is_mine(const os::Ipv4& address) const;
  /// Returns true if a packet with this sender comes from this machine. If a lost address sends, another
  /// machine has it now.
  bool comes_from_here(const os::Ipv4& sender);
  /// Returns false if the participant must not use this address.
  [[nodiscard]] bool allows(const os::Ipv4& address) const;
  /// Returns true if the participant takes a packet that was sent to this address, or to this multicast
  /// group, and came in on this interface. The kernel also gives it those to other addresses, and to groups
  /// that other processes of this machine receive on other interfaces.
  [[nodiscard]] bool receives(const os::Ipv4& to, int interface) const;
  /// Notes that another machine has sent something to this address.
  void heard_at(const os::Ipv4& address);

 private:
  const Options options_;
  mutable std::mutex mutex_;
  List all_;
  List used_;
  List settled_;  // what used_ was when settle() was called last
  std::set<os::Ipv4> heard_;
  std::set<os::Ipv4> lost_;
};

}  // namespace takt::dds
