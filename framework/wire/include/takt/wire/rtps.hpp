// Checks whether bytes are a valid RTPS message (DDSI-RTPS 2.5, 9.4), and whether it may arrive unencrypted
// although DDS Security is on.
//
// Fast DDS trusts the lengths in a message, and some forged messages end the process. This version frees
// memory that it never allocated for a DATA_FRAG without content (CVE-2023-50716). It aborts on statistics in
// an unexpected form, and copies a text that claims to be longer than all memory (in a token or an
// authentication message). With security it accepts an unencrypted HEARTBEAT from anyone who uses a member's
// GUID. So each message is checked against the specification before Fast DDS sees it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::wire {

/// Whether bytes are a certificate that can be used for authentication.
using IsCertificate = bool (*)(std::span<const std::uint8_t>) noexcept;

/// The number of bytes that Fast DDS may read; 0 if the message is not valid. In a valid message every
/// submessage has the content of its kind within its own length, and parameter lists and counted items end.
/// The sender and the meaning are not checked. Statistics at the end are cut off. `is_certificate` may be
/// null. Any thread; allocates no more than `is_certificate` does.
[[nodiscard]] std::size_t readable_rtps(std::span<const std::uint8_t> message,
                                        IsCertificate is_certificate = nullptr) noexcept;

/// Whether a readable message is encrypted, as a whole or in each submessage. Discovery and authentication of
/// participants may be unencrypted. Any thread; does not allocate.
[[nodiscard]] bool is_protected_rtps(std::span<const std::uint8_t> message) noexcept;

/// The GUID prefix of a participant: the first 12 bytes of the GUIDs of everything that belongs to it.
using ParticipantNumber = std::array<std::uint8_t, 12>;

struct Announcement {
  enum class Of : std::uint8_t { nobody, sender, other };
  Of of = Of::nobody;
  ParticipantNumber number{};   ///< of the sender
  std::uint32_t lease_s = ~0U;  ///< after this time without a message the participant counts as gone, s
};

/// Which participant a message announces that passed is_protected_rtps(). `other`: a participant that is not
/// the sender, or more than one. Any thread; does not allocate.
[[nodiscard]] Announcement announcement_in(std::span<const std::uint8_t> message) noexcept;

}  // namespace takt::wire
