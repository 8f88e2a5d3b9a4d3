// Drops packets that are not valid RTPS messages, before Fast DDS reads them. With DDS Security, it also
// drops packets that are not encrypted, those of participants whose certificate is no longer valid, and
// announcements of unauthenticated participants above the limits.
// While a reader is created or deleted, no packet is handled. Only the source files of this room include this
// header.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/os/network.hpp>
#include <takt/os/udp_socket.hpp>
#include <takt/wire/notices.hpp>
#include <takt/wire/rtps.hpp>
#include <takt/wire/unauthenticated_participants.hpp>
#include "workarounds/receive_lock.hpp"

namespace takt::dds {

/// With which participants the process exchanges no packets at the moment.
enum class Silence { none, on_this_machine, on_other_machines, everywhere };

/// How a packet arrived.
struct Arrival {
  os::Ipv4 from{};
  bool here = false;      ///< it comes from this machine
  bool in_group = false;  ///< it was sent to a multicast group
};

/// The discovery server of a client.
struct FollowedServer {
  wire::ParticipantNumber number;
  os::Ipv4 placeholder;  ///< see HostNames
  std::uint16_t port;
  std::function<void(const std::vector<os::Ipv4>&)> announced;  ///< called with each announcement's addresses
};

/// The filter of the process's participant. Any thread may call its functions.
class PacketFilter {
 public:
  PacketFilter(wire::Notices& notices, bool secured) : notices_(notices), secured_(secured) {}

  /// Calls `handle` with the number of bytes that Fast DDS may read, unless the packet must be dropped.
  /// Changes the packet where Fast DDS must skip a part of it.
  void pass(std::span<std::uint8_t> packet, const Arrival& arrival,
            const std::function<void(std::size_t)>& handle);
  /// Returns true if no packet may be sent to participants on this machine, or on others.
  [[nodiscard]] bool is_silent(bool here) const noexcept {
    const Silence now = silence;
    return now == Silence::everywhere ||
           now == (here ? Silence::on_this_machine : Silence::on_other_machines);
  }

  /// Lets `look` see each announcement that a participant makes of itself, with the address that it comes
  /// from, before Fast DDS reads it. Anybody may have sent it. Only with DDS Security; call this function
  /// before packets arrive.
  void look_at_announcements(std::function<void(const wire::Announcement&, const os::Ipv4&)> look) {
    look_ = std::move(look);
  }
  /// Lets Fast DDS send all discovery messages for this server to its placeholder, whatever addresses it
  /// announces. Call this function before packets arrive.
  ///
  /// A client of Fast DDS announces itself to the address of the server that it was given, but acknowledges
  /// and requests at the addresses that the server announced last. If the server's machine gets another
  /// address, or if the server is started again on another machine, the client learns the new addresses from
  /// the server, but does not use them.
  void follow(FollowedServer server) { server_ = std::move(server); }
  /// Calls `reported` with each report that another participant has lost the participant `own`, and with the
  /// time of the sender's last encrypted message to this participant alone. Anybody may have sent the report.
  /// Only with DDS Security.
  void take_loss_reports(
      const wire::ParticipantNumber& own,
      std::function<void(const wire::ParticipantNumber& by, std::optional<Instant> heard)> reported);
  /// Sends a packet past Fast DDS. The transport sets it before the participant exists.
  std::function<void(std::span<const std::uint8_t> packet, const os::UdpEnd& to)> send;
  /// From now on, drops every packet of this participant, also its announcements.
  void reject(const wire::ParticipantNumber& participant);

  /// Returns the sender of the packet that this thread handles, or has handled last.
  [[nodiscard]] static os::Ipv4 sender() noexcept;

  /// Returns when the last message of this participant arrived that can be decrypted, is not an announcement
  /// and was not sent to a multicast group: what a participant sends to a group is meant for those that it
  /// has matched, but everybody receives it.
  [[nodiscard]] std::optional<Instant> last_message_of(const wire::ParticipantNumber& participant) const;

  wire::UnauthenticatedParticipants unauthenticated;  // used only with DDS Security
  std::atomic<std::uint64_t> refused{0};
  std::atomic<Silence> silence{Silence::none};
  ReceiveLock receive_lock;

 private:
  void drop(const os::Ipv4& from, const char* why);
  [[nodiscard]] bool is_rejected(std::span<const std::uint8_t> packet) const;
  bool take_loss_report(std::span<const std::uint8_t> packet);

  wire::Notices& notices_;
  const bool secured_;
  std::function<void(const wire::Announcement&, const os::Ipv4&)> look_;
  std::optional<FollowedServer> server_;
  mutable std::mutex mutex_;
  wire::ParticipantNumber own_{};
  std::function<void(const wire::ParticipantNumber&, std::optional<Instant>)> reported_;
  struct Heard {
    Instant last;
    std::optional<Instant> encrypted{};  // the last message that only the participant could send
  };
  std::map<wire::ParticipantNumber, Heard> heard_;
  std::set<wire::ParticipantNumber> rejected_;  // a new process has another number, so none is removed
  std::atomic<bool> any_rejected_{false};
};

}  // namespace takt::dds
