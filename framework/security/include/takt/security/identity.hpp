// The folder of one participant of a secured cell, with its identity and its permissions.
//
// Fast DDS reports any mistake in these files as "initialization error". So Takt checks the files first.
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
inline constexpr const char* kIdentityAuthority = "ca.cert.pem";  ///< certificate that issues identities
inline constexpr const char* kAccessAuthority =
    "permissions.cert.pem";  ///< certificate that signs the documents
inline constexpr const char* kCertificate = "identity.cert.pem";
inline constexpr const char* kPrivateKey = "identity.key.pem";
inline constexpr const char* kGovernance = "governance.smime";
inline constexpr const char* kPermissions = "permissions.smime";
inline constexpr const char* kRevoked = "crl.pem";
/// If this file exists, components are loaded only if they are signed with its key.
inline constexpr const char* kComponents = "components.cert.pem";

/// A warning appears if a certificate is valid for less than this time.
inline constexpr std::int64_t kSoon = std::int64_t{30} * 24 * 3600;  // s

struct Identity {
  Subject subject;
  std::string authority;     ///< the name of its issuer, as participants announce it on DDS
  std::string folder;        ///< an absolute path
  std::int64_t until = 0;    ///< end of validity of its certificate, in seconds since 1970
  std::vector<int> domains;  ///< the domains of its permissions
};

/// Reads and checks every file of the folder. Fails with all problems, each with its file:
/// - a file is missing or cannot be read,
/// - the certificate was issued by another authority, is revoked, or is not valid at this time (seconds since
/// 1970),
/// - the key does not belong to the certificate, or other users may read it,
/// - a document is not signed, or belongs to another subject.
Result<Identity> read_identity(const std::string& folder, std::int64_t now);

/// If `folder` was made by `takt secure init`, returns the folder of the identity with this role and name in
/// it. Without a name, returns the choice of first_of() at the current time. Returns any other `folder`
/// itself.
std::string folder_of(const std::string& folder, Role role, const std::string& name = {});

/// Whether the bytes are a certificate (PEM) with a subject. A certificate without a subject would crash Fast
/// DDS 2.9.1 even before its issuer is checked. Any thread may call it.
bool names_somebody(std::span<const std::uint8_t> certificate) noexcept;

/// "it expires in 12 days"; empty if there are at least 30 days left.
std::string expiry_warning(std::int64_t until, std::int64_t now);

/// The first bytes of the GUIDs of all participants with this identity on DDS. Authentication checks them
/// against the subject of the certificate, so that no other identity can use them.
using Prefix = std::array<std::uint8_t, 6>;
Prefix prefix_of(const Subject& subject);

}  // namespace takt::security
