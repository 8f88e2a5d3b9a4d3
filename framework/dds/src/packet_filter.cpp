#include "packet_filter.hpp"

#include <cstring>
#include <string>

#include <takt/os/clock.hpp>
#include <takt/security/identity.hpp>
#include <takt/wire/rtps.hpp>
#include "workarounds/message_size.hpp"
#include "workarounds/own_announcement.hpp"

namespace takt::dds {

namespace {

// Participants that have ended leave their number behind. If there are so many, all are forgotten.
constexpr std::size_t kMostSenders = 4096;

thread_local os::Ipv4 sender_of_this_packet{};

}  // namespace

os::Ipv4 PacketFilter::sender() noexcept { return sender_of_this_packet; }

void PacketFilter::pass(std::span<std::uint8_t> packet, const Arrival& arrival,
                        const std::function<void(std::size_t)>& handle) {
  const os::Ipv4& from = arrival.from;
  if (is_silent(arrival.here)) return;
  if (secured_ && take_loss_report(packet)) return;
  const std::size_t readable = wire::readable_rtps(packet, secured_ ? &security::names_somebody : nullptr);
  if (readable == 0) return drop(from, "it is not a valid RTPS message");
  packet = packet.first(readable);
  if (is_rejected(packet)) return;  // reported when it was rejected
  if (secured_) {
    if (!wire::is_protected_rtps(packet)) return drop(from, "it is not encrypted");
    const wire::Announcement announcement = wire::announcement_in(packet);
    std::uint32_t address = 0;
    std::memcpy(&address, from.data(), sizeof address);
    if (announcement.of != wire::Announcement::Of::nobody) {
      if (!unauthenticated.admit(announcement, address))
        return drop(
            from, "it announces an invalid participant, or there are too many unauthenticated participants");
      if (look_) look_(announcement, from);
    }
  }
  if (!arrival.here) heard_from_afar();
  wire::skip_unused_parameters(packet);
  sender_of_this_packet = from;
  // Fast DDS must not handle two announcements of a participant at once; see participant_removal.hpp.
  if (wire::concerns_participants(packet)) {
    set_near(wire::sender_of(packet), arrival.here);
    if (server_) {
      const auto addresses =
          wire::replace_addresses(packet, server_->number, server_->placeholder, server_->port);
      if (!addresses.empty()) server_->announced(addresses);
    }
    receive_lock.handle_alone([&] {
      handle(readable);
      follow_client();
    });
  } else {
    const bool is_readable = secured_ || !wire::is_protected_rtps(packet);
    if (is_readable && !arrival.in_group) {
      const std::lock_guard lock{mutex_};
      if (heard_.size() == kMostSenders) heard_.clear();
      Heard& heard = heard_[wire::sender_of(packet)];
      heard.last = os::now();
      if (secured_ && wire::is_encrypted(packet)) heard.encrypted = heard.last;
    }
    receive_lock.handle([&] { handle(readable); });
  }
}

std::optional<Instant> PacketFilter::last_message_of(const wire::ParticipantNumber& participant) const {
  const std::lock_guard lock{mutex_};
  const auto found = heard_.find(participant);
  return found == heard_.end() ? std::nullopt : std::optional{found->second.last};
}

void PacketFilter::take_loss_reports(
    const wire::ParticipantNumber& own,
    std::function<void(const wire::ParticipantNumber&, std::optional<Instant>)> reported) {
  const std::lock_guard lock{mutex_};
  own_ = own;
  reported_ = std::move(reported);
}

bool PacketFilter::take_loss_report(std::span<const std::uint8_t> packet) {
  if (packet.size() != std::tuple_size_v<wire::LossReport>) return false;
  const std::lock_guard lock{mutex_};
  if (!reported_ || !wire::is_loss_report(packet, own_)) return false;
  const auto found = heard_.find(wire::sender_of(packet));
  reported_(wire::sender_of(packet), found == heard_.end() ? std::nullopt : found->second.encrypted);
  return true;
}

void PacketFilter::reject(const wire::ParticipantNumber& participant) {
  const std::lock_guard lock{mutex_};
  rejected_.insert(participant);
  any_rejected_.store(true, std::memory_order_relaxed);
}

bool PacketFilter::is_rejected(std::span<const std::uint8_t> packet) const {
  if (!any_rejected_.load(std::memory_order_relaxed)) return false;
  const std::lock_guard lock{mutex_};
  return rejected_.contains(wire::sender_of(packet));
}

void PacketFilter::drop(const os::Ipv4& from, const char* why) {
  refused.fetch_add(1, std::memory_order_relaxed);
  notices_.tell("dropped a packet from " + os::in_dots(from) + ": " + why);
}

}  // namespace takt::dds
