// The folder of one participant of a secured cell: who it is, and what it may do.
//
// Fast DDS says of whatever is wrong with these files "initialization error". So they are looked at before.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

namespace takt::security {

/// The files of such a folder.
inline constexpr const char* kIdentityAuthority = "ca.cert.pem";         ///< that issues identities
inline constexpr const char* kAccessAuthority = "permissions.cert.pem";  ///< that signs the two documents
inline constexpr const char* kCertificate = "identity.cert.pem";
inline constexpr const char* kPrivateKey = "identity.key.pem";
inline constexpr const char* kGovernance = "governance.smime";
inline constexpr const char* kPermissions = "permissions.smime";
inline constexpr const char* kRevoked = "crl.pem";
/// If it is there, components are loaded only if they are signed with its key.
inline constexpr const char* kComponents = "components.cert.pem";

/// A certificate that is valid for less than this is warned of.
inline constexpr std::int64_t kSoon = std::int64_t{30} * 24 * 3600;  // s

struct Identity {
  Subject subject;
  std::string authority;     ///< the name of who issued it, as participants announce it on DDS
  std::string folder;        ///< an absolute path
  std::int64_t until = 0;    ///< its certificate is valid until then, seconds since 1970
  std::vector<int> domains;  ///< that its permissions are for
};

/// Reads and checks every file: that it is there, who issued it, that it is valid at this time (seconds since
/// 1970) and not revoked, that key and certificate belong together, that the documents are signed and of this
/// subject, that nobody else may read the key. Fails with all that is wrong, each with its file.
Result<Identity> read_identity(const std::string& folder, std::int64_t now);

/// The folder of this device, operator or other below one that `takt secure init` made; else `folder` itself.
/// Without a name: as first_of() has it at present.
std::string folder_of(const std::string& folder, Role role, const std::string& name = {});

/// Whether it is a certificate (PEM) with a subject. One without a subject ends a process of Fast DDS 2.9.1
/// that asks for its name, before it is known who issued it. Any thread.
bool names_somebody(std::span<const std::uint8_t> certificate) noexcept;

/// "it expires in 12 days"; empty while there is time.
std::string expiry_warning(std::int64_t until, std::int64_t now);

/// How the numbers of all participants with this identity begin on DDS. Whoever authenticates holds the
/// certificate's subject against it, so that no other identity has them.
using Prefix = std::array<std::uint8_t, 6>;
Prefix prefix_of(const Subject& subject);

}  // namespace takt::security
