// Keeps RTPS messages so short that every usual path carries each one in one IP packet. Fast DDS fills
// messages up to the size that the transport allows, which must be 65,500 bytes for fast communication within
// a machine. On the way to another machine, the kernel splits such a message into IP fragments. If one
// fragment is lost, the whole message is lost. Many VPNs and firewalls drop all fragments, so such a message
// never arrives, and Fast DDS sends it again for ever.
//
// This file makes all writers split samples into fragments of RTPS (DATA_FRAG), which a reader requests one
// by one, and sends a message before it exceeds kLongestFarMessage. Messages to participants of this machine
// may be longer, and fragments too while no other machine sends anything.
#pragma once

#include <cstdint>
#include <span>

#include <takt/wire/rtps.hpp>

namespace takt::dds {

/// The length of the longest message to another machine, in bytes. With the headers of IP and UDP, such a
/// message fits into an IP packet of 1280 bytes: the smallest size that IPv6 requires, and a usual one for a
/// VPN.
inline constexpr std::uint32_t kLongestFarMessage = 1252;

/// Call this function once before the process creates a participant. `secured`: the participant uses DDS
/// Security, which makes messages longer.
void keep_messages_short(bool secured) noexcept;

/// Messages to this participant may be long if it is on this machine (`near`).
void set_near(const wire::ParticipantNumber& participant, bool near);
[[nodiscard]] bool is_near(const wire::ParticipantNumber& participant);

/// Call this function when a message from another machine arrives.
void heard_from_afar();

}  // namespace takt::dds
