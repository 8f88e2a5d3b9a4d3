// Reads the identity folder of one participant of a secured cell. The folder contains the identity and the
// permissions of the participant.
//
// Fast DDS reports every error in these files only as "initialization error". So Takt checks the files before
// Fast DDS reads them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/security/access.hpp>

struct x509_st;  // a certificate of OpenSSL

namespace takt::security {

/// The files in an identity folder.
inline constexpr const char* kIdentityAuthority = "ca.cert.pem";  ///< certificate of the authority's key for
                                                                  ///< identities
inline constexpr const char* kAccessAuthority =
    "permissions.cert.pem";  ///< certificate of the authority's key for documents
inline constexpr const char* kCertificate = "identity.cert.pem";
inline constexpr const char* kPrivateKey = "identity.key.pem";
inline constexpr const char* kGovernance = "governance.smime";
inline constexpr const char* kPermissions = "permissions.smime";
inline constexpr const char* kRevoked = "crl.pem";
/// The certificate of the key that signs components. If this file exists, a node loads only components that
/// are signed with this key.
inline constexpr const char* kComponents = "components.cert.pem";

/// Takt warns if a certificate expires in less than this time.
inline constexpr std::int64_t kSoon = std::int64_t{30} * 24 * 3600;  // s

struct Identity {
  Subject subject;
  std::string authority;     ///< name of the authority, as participants announce it
  std::string folder;        ///< an absolute path
  std::int64_t until = 0;    ///< end of the validity of the identity's certificate, in seconds since 1970
  std::string serial{};      ///< serial number of the identity's certificate
  std::vector<int> domains;  ///< the domains for which the identity has permissions
};

/// Reads and checks every file of the folder. Fails with one problem for each of these errors; each problem
/// names the file:
/// - a file is missing or cannot be read,
/// - the certificate was issued by another authority, is revoked, or is not valid at the time `now` (in
///   seconds since 1970),
/// - the key does not belong to the certificate, or other users may read it,
/// - a document is not signed, or belongs to another subject.
Result<Identity> read_identity(const std::string& folder, std::int64_t now);

/// Returns the folder of the identity with this role and name, if `takt secure init` created `folder`;
/// otherwise `folder` itself. If `name` is empty, returns the folder that first_of() chooses at the current
/// time.
std::string folder_of(const std::string& folder, Role role, const std::string& name = {});

/// Returns true if the bytes are a PEM certificate with a subject. A certificate without a subject would
/// crash Fast DDS 2.9.1, even before Fast DDS checks the issuer. Any thread may call this function.
bool names_somebody(std::span<const std::uint8_t> certificate) noexcept;

/// What a certificate says about its participant.
struct Certified {
  Subject subject;         ///< without names if the authority has issued the certificate by other means
  std::int64_t until = 0;  ///< end of the validity, in seconds since 1970
  std::string serial;      ///< the number under which the authority may revoke it
};
/// Reads a certificate that has been verified. Any thread may call this function.
Certified certified(const x509_st& certificate);

/// Returns a text such as "it expired on 2027-11-27 at 12:00:00 UTC".
std::string expired_text(std::int64_t until);
/// Returns a text such as "it expires in 12 days", or that of expired_text(); empty if at least 30 days are
/// left.
std::string expiry_warning(std::int64_t until, std::int64_t now);

/// The first bytes of the GUID of each DDS participant with a given identity. Authentication compares these
/// bytes with the subject of the certificate, so that no other identity can use them.
using Prefix = std::array<std::uint8_t, 6>;
Prefix prefix_of(const Subject& subject);

}  // namespace takt::security
