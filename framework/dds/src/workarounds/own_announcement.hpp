// What this participant announces of itself, after its addresses have changed or it was halted. Only the
// source files of this room include this header.
//
// In Fast DDS 2.9.1, a participant adds new addresses to its announcement, but removes none, and its readers
// and writers announce for ever the addresses that it had when they were created. The other participants send
// their discovery messages for ever to the addresses that it announced first.
//
// Participants that hear nothing of a halted one for the lease forget it. But the halted one does not forget
// them, because their announcements wait in its socket. With DDS Security, Fast DDS 2.9.1 then never
// authenticates the two again: one side begins a new authentication, and the other side ignores it, because
// it has already authenticated its partner. So they do not communicate again until one of them ends or
// rejoins, or until a loss was reported (loss_reports.hpp).
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include <takt/os/network.hpp>
#include "../fast_dds.hpp"
#include "../packet_filter.hpp"

namespace takt::dds {

// Each pause between the first announcements is twice as long as the one before: 20, 40 ... 320 ms.
inline constexpr std::uint32_t kFirstAnnouncements = 5;
inline constexpr Nanoseconds kFirstPause = std::chrono::milliseconds{20};
// After another participant was found, more announcements follow: after 100 and 300 ms.
inline constexpr std::uint32_t kMoreAnnouncements = 2;
inline constexpr Nanoseconds kMorePause = std::chrono::milliseconds{100};

/// Finds the functions of Fast DDS that own_announcement.cpp replaces; ends the process if one is missing.
/// Call this function before the participant of this process is created. `follows` says whether this
/// participant sends discovery messages to the new addresses of others that announce some; with DDS Security
/// it cannot. `serves`: it is a discovery server.
void prepare_own_announcement(bool follows, bool serves) noexcept;
/// From now on, this participant announces these addresses, also those of its new readers and writers. Its
/// present readers and writers announce them when their QoS is set again. Any thread but a real-time one may
/// call this function while the participant exists.
void announce_addresses(fast::DomainParticipant& participant, const std::vector<os::Ipv4>& addresses);
/// Announces this participant once more.
void announce_again();
/// The participant listener calls this function when a participant was found or has changed.
void has_announced(const rtps::GuidPrefix_t& participant) noexcept;
/// If the participant of this process is a discovery server, it sends discovery messages to the new addresses
/// of the client that this thread last passed to has_announced(). The packet filter calls this function while
/// no other announcement is handled and no participant is removed.
void follow_client();
/// Makes the participant of this process forget another one, until that one announces itself again. Any
/// thread but a real-time one may call this function while the participant exists.
void forget(const wire::ParticipantNumber& participant);
/// Makes the participant of this process forget another one that has not announced itself for longer than its
/// lease, in case that Fast DDS does not: version 3 does not before that one has authenticated. Any thread
/// but a real-time one may call this function while the participant exists.
void forget_silent(const wire::ParticipantNumber& participant);
/// Makes the participant of this process forget others and be forgotten by them, and announces it again. For
/// half a second in between, the process exchanges nothing with them. The listeners report that they are lost
/// and found again. `also_here`: participants on this machine, too, and not only those on others. Any thread
/// but a real-time one may call this function while the participant exists.
void rejoin(PacketFilter& filter, const std::map<wire::ParticipantNumber, std::string>& known,
            bool also_here);

}  // namespace takt::dds
