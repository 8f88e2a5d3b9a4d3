// Checks whether bytes are a valid RTPS message (DDSI-RTPS 2.5, 9.4), and whether it may arrive unencrypted
// although DDS Security is on.
//
// Fast DDS 2.9.1 trusts the lengths in a message, so some forged messages end the process. For a DATA_FRAG
// without content it frees memory that it never allocated (CVE-2023-50716). It aborts if statistics have an
// unexpected form. In tokens and authentication messages it copies a text of any claimed length, even beyond
// all memory. With security it accepts an unencrypted HEARTBEAT from anyone who uses a member's GUID. So each
// message is checked against the specification before Fast DDS sees it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace takt::wire {

/// Whether bytes are a certificate that can be used for authentication.
using IsCertificate = bool (*)(std::span<const std::uint8_t>) noexcept;

/// Returns the number of bytes that Fast DDS may read; 0 if the message is not valid. In a valid message,
/// every submessage contains what its kind requires, within its own length. Its parameter lists and counted
/// items are complete. The sender and the meaning are not checked. Statistics at the end are not counted as
/// readable. `is_certificate` may be null. Any thread may call this; only `is_certificate` may allocate.
[[nodiscard]] std::size_t readable_rtps(std::span<const std::uint8_t> message,
                                        IsCertificate is_certificate = nullptr) noexcept;

/// Whether a readable message is encrypted, as a whole or in each submessage. Discovery and authentication of
/// participants may be unencrypted. Any thread may call this; it does not allocate.
[[nodiscard]] bool is_protected_rtps(std::span<const std::uint8_t> message) noexcept;

/// The GUID prefix of a participant: the first 12 bytes of the GUIDs of everything that belongs to it.
using ParticipantNumber = std::array<std::uint8_t, 12>;

struct Announcement {
  enum class Of : std::uint8_t { nobody, sender, other };
  Of of = Of::nobody;
  ParticipantNumber number{};   ///< the sender's number
  std::uint32_t lease_s = ~0U;  ///< time in s without a message after which the participant is lost
};

/// Returns which participant a message announces. The message must have passed is_protected_rtps(). `other`
/// means a participant that is not the sender, or several participants. Any thread may call this; it does not
/// allocate.
[[nodiscard]] Announcement announcement_in(std::span<const std::uint8_t> message) noexcept;

}  // namespace takt::wire
