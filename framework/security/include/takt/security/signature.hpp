// Signatures of files, beside them as FILE.sig: what `openssl dgst -sha256 -sign` writes, so that others can
// make and check them.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>

namespace takt::security {

/// The largest file that is signed.
inline constexpr std::size_t kMostSigned = std::size_t{1} << 30;

/// Writes FILE.sig. `key`: PEM.
Result<void> sign_file(const std::string& file, const std::string& key);

/// Fails where this file is no certificate that signatures can be checked with at this time (seconds since
/// 1970), and names it.
Result<void> check_signer(const std::string& certificate, std::int64_t now);

/// Fails where there is no FILE.sig, or it was not made of this file with the key of this certificate (a
/// file), or the certificate is not valid at this time (seconds since 1970).
Result<void> check_signature(const std::string& file, const std::string& certificate, std::int64_t now);

}  // namespace takt::security
