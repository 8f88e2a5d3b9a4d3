// Checks whether bytes are a valid RTPS message (DDSI-RTPS 2.5, 9.4), and whether it is encrypted as DDS
// Security requires.
//
// Fast DDS 2.9.1 trusts the lengths in a message, so some forged messages crash the process. For a DATA_FRAG
// without content, Fast DDS frees memory that it never allocated (CVE-2023-50716). A malformed statistics
// submessage makes Fast DDS abort. In tokens and authentication messages, Fast DDS copies texts of any
// claimed length, even beyond the end of its memory. With security, it accepts an unencrypted HEARTBEAT from
// anyone who uses a member's GUID. So Takt checks each message against the specification before Fast DDS
// reads it. docs/secure.md lists the known vulnerabilities of Fast DDS 2.9.1.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace takt::wire {

/// A function that returns true if the bytes are a certificate that can be used for authentication.
using IsCertificate = bool (*)(std::span<const std::uint8_t>) noexcept;

/// Returns the number of bytes that Fast DDS may read; 0 if the message is not valid. In a valid message,
/// every submessage contains, within its own length, the fields that its kind requires. The parameter lists
/// and counted items of the message are complete. This function checks neither the sender nor the meaning of
/// the message. Fast DDS must not read a statistics submessage at the end of the message, so the bytes of
/// this submessage are not counted. `is_certificate` may be null. Any thread may call this function; only
/// `is_certificate` may allocate.
[[nodiscard]] std::size_t readable_rtps(std::span<const std::uint8_t> message,
                                        IsCertificate is_certificate = nullptr) noexcept;

/// Makes Fast DDS skip the parameters of a readable message that Takt does not need: content filters, and the
/// descriptions of types, of which a small one can cost much memory and time. Any thread may call this
/// function; it does not allocate.
void skip_unused_parameters(std::span<std::uint8_t> message) noexcept;

/// Returns true if Fast DDS may read this authentication message, which it has assembled from fragments:
/// readable_rtps() checks only the fragments. `content` begins with the encapsulation. `is_certificate` may
/// be null.
[[nodiscard]] bool is_readable_proof(std::span<const std::uint8_t> content,
                                     IsCertificate is_certificate = nullptr) noexcept;

/// Returns true if a readable message is encrypted as required: as a whole or in each submessage.
/// Announcements and authentication messages of participants may be unencrypted. Any thread may call this
/// function; it does not allocate.
[[nodiscard]] bool is_protected_rtps(std::span<const std::uint8_t> message) noexcept;

/// Returns true if a readable message for which is_protected_rtps() returned true has an encrypted part. Any
/// thread may call this function; it does not allocate.
[[nodiscard]] bool is_encrypted(std::span<const std::uint8_t> message) noexcept;

/// Returns true if a readable message announces that a participant exists, has changed or leaves. Any thread
/// may call this function; it does not allocate.
[[nodiscard]] bool concerns_participants(std::span<const std::uint8_t> message) noexcept;

/// The GUID prefix of a participant: the first 12 bytes of its GUID and of the GUIDs of its readers and
/// writers.
using ParticipantNumber = std::array<std::uint8_t, 12>;

/// Returns the GUID prefix of the sender of a readable message.
[[nodiscard]] ParticipantNumber sender_of(std::span<const std::uint8_t> message) noexcept;

/// Replaces the addresses at which a participant receives discovery messages in its announcements of itself:
/// a readable message then announces only this IPv4 address and port. Returns the IPv4 addresses that it
/// announced before; none if it announces no or another participant. Any thread may call this function; it
/// allocates memory for the result.
std::vector<std::array<std::uint8_t, 4>> replace_addresses(std::span<std::uint8_t> message,
                                                           const ParticipantNumber& participant,
                                                           const std::array<std::uint8_t, 4>& address,
                                                           std::uint16_t port);

struct Announcement {
  enum class Of : std::uint8_t { nobody, sender, other };
  Of of = Of::nobody;
  ParticipantNumber number{};   ///< the GUID prefix of the sender
  std::uint32_t lease_s = ~0U;  ///< in s; a participant that announces nothing for this time is lost
  std::string_view name{};      ///< the name of the participant
  /// The identity that the participant claims, such as "/O=cell/OU=device/CN=robot"; empty: none.
  std::string_view subject{};
  std::string_view authority{};  ///< who issued this identity
  bool has_version = false;      ///< contains a version of Fast DDS, as those of Fast DDS 3 do
  std::uint16_t port = 0;  ///< where the participant receives discovery messages (UDP, IPv4); 0: unknown
};

/// Returns which participant a message announces. Requires that is_protected_rtps() returned true for the
/// message. `other` means that the message announces another participant than its sender, or several. The
/// texts in the announcement are parts of the message. Any thread may call this function; it does not
/// allocate.
[[nodiscard]] Announcement announcement_in(std::span<const std::uint8_t> message) noexcept;

/// A message with which a participant tells another one that it has lost it. Only Takt knows this message: it
/// consists of a vendor-specific submessage.
using LossReport = std::array<std::uint8_t, 40>;
[[nodiscard]] LossReport loss_report(const ParticipantNumber& sender, const ParticipantNumber& lost) noexcept;
/// Returns true if these bytes are such a message about the participant `lost`. sender_of() returns who has
/// lost it. Any thread may call this function; it does not allocate.
[[nodiscard]] bool is_loss_report(std::span<const std::uint8_t> bytes,
                                  const ParticipantNumber& lost) noexcept;

}  // namespace takt::wire
