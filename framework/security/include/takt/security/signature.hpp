// Signatures of files, stored beside them as FILE.sig. The format is that of `openssl dgst -sha256 -sign`, so
// that other tools can create and verify them.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>

namespace takt::security {

/// The maximum size of a file to sign, in bytes.
inline constexpr std::size_t kMostSigned = std::size_t{1} << 30;

/// Writes FILE.sig. `key` is a private key as PEM text.
Result<void> sign_file(const std::string& file, const std::string& key);

/// Fails if the file `certificate` is not a certificate that is valid at this time (seconds since 1970).
Result<void> check_signer(const std::string& certificate, std::int64_t now);

/// `certificate` is the path of a certificate. Fails if FILE.sig does not exist, if it was not made from this
/// file with the key of the certificate, or if the certificate is not valid at this time (seconds since
/// 1970).
Result<void> check_signature(const std::string& file, const std::string& certificate, std::int64_t now);

}  // namespace takt::security
