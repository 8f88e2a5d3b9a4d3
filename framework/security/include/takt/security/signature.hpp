// Signs files and checks their signatures. The signature of FILE is in FILE.sig, in the same folder. The
// format is that of `openssl dgst -sha256 -sign`, so that other tools can create and verify signatures.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::security {

/// The largest size of a file that can be signed, in bytes.
inline constexpr std::size_t kMostSigned = std::size_t{1} << 30;

/// Signs `file` and writes the signature to FILE.sig, or to the file to which the link FILE.sig leads. Fails
/// if another user can change this link. `key` is a private key as PEM text.
Result<void> sign_file(const std::string& file, const std::string& key);

/// Checks that the file `certificate` is a certificate that has not expired at the time `now` (in seconds
/// since 1970).
Result<void> check_signer(const std::string& certificate, std::int64_t now);

/// Checks the signature of `file` in FILE.sig. `copy` is a copy of the file that nobody can change.
/// `certificate` is the path of a certificate. Fails if FILE.sig does not exist, if it is not the signature
/// of the copy with the key of the certificate, or if the certificate has expired at the time `now` (in
/// seconds since 1970).
Result<void> check_signature(const std::string& file, const os::Fd& copy, const std::string& certificate,
                             std::int64_t now);
/// Returns a function that calls check_signature() with this certificate and the present time.
std::function<Result<void>(const std::string& file, const os::Fd& copy)> signature_check(
    std::string certificate);

}  // namespace takt::security
