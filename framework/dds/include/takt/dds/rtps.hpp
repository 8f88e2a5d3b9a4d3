// What is an RTPS message at all (DDSI-RTPS 2.5, 9.4), and what of it may come in the clear where DDS
// Security is on. Fast DDS reads on where a stranger's message says so, and some of them end it: this version
// frees what it never had for a DATA_FRAG without content (CVE-2023-50716), breaks off where its own
// statistics are not as it would have sent them, and copies a text that is longer than all memory (a token,
// or a message by which somebody proves who he is). With security it takes a HEARTBEAT that is not encrypted
// from whoever uses a member's number. So each message is held against the specification before it sees it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::dds {

/// Whether bytes are a certificate that somebody may prove himself with.
using IsCertificate = bool (*)(std::span<const std::uint8_t>) noexcept;

/// Every submessage has what its kind must have, within its own length; lists of parameters end, and so does
/// what they count. That says nothing about who sent it, or whether it makes sense. Bytes of the message that
/// are to be read: statistics at its end are for nobody here. 0: it is none. Any thread; allocates no more
/// than `is_certificate` does, which may be null.
[[nodiscard]] std::size_t readable_rtps(std::span<const std::uint8_t> message,
                                        IsCertificate is_certificate = nullptr) noexcept;

/// Of a readable one: it is encrypted, as a whole or in each submessage, but for those by which participants
/// find each other and prove who they are. Any thread; does not allocate.
[[nodiscard]] bool is_protected_rtps(std::span<const std::uint8_t> message) noexcept;

/// The first 12 bytes of whatever belongs to a participant.
using ParticipantNumber = std::array<std::uint8_t, 12>;

struct Announcement {
  enum class Of : std::uint8_t { nobody, sender, other };
  Of of = Of::nobody;
  ParticipantNumber number{};   ///< of the sender
  std::uint32_t lease_s = ~0U;  ///< without a word for so long it is gone, s
};

/// Who is said to be there by one that is_protected_rtps(). `other`: not its sender, or more than one. Any
/// thread; does not allocate.
[[nodiscard]] Announcement announcement_in(std::span<const std::uint8_t> message) noexcept;

}  // namespace takt::dds
