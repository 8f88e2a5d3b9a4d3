#include <takt/security/signature.hpp>

#include <openssl/err.h>
#include <openssl/evp.h>

#include <filesystem>
#include <utility>

#include <takt/core/check.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/sealed_copy.hpp>
#include <takt/os/writers.hpp>
#include "pki.hpp"

namespace takt::security {

namespace {

using Digest = std::unique_ptr<EVP_MD_CTX, FreedBy<EVP_MD_CTX_free>>;

constexpr std::size_t kMostPem = std::size_t{1} << 20;

const unsigned char* bytes(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

Result<std::string> read_signed_file(const std::string& path, std::size_t most, const char* fix) {
  auto content = os::read_file(path, most);
  if (!content) return content.problems();
  if (!*content) return Problem{path, "there is no such file", fix};
  return **std::move(content);
}

std::string signature_of(const std::string& file) { return file + ".sig"; }

Result<Certificate> signer(const std::string& file, std::int64_t now) {
  constexpr const char* kName =
      "name the certificate that takt sign prints: DIR/authority/components.cert.pem";
  if (auto writers = os::check_writers(file); !writers) return writers.problems();
  const auto pem = read_signed_file(file, kMostPem, kName);
  if (!pem) return pem.problems();
  Certificate certificate = certificate_from(*pem);
  if (certificate == nullptr) return Problem{file, "it is not a certificate", kName};
  if (valid_until(*certificate) <= now) return Problem{file, "it has expired", "sign the components again"};
  return certificate;
}

/// Follows a link, as other output files do, but only if no other user decides where it leads. Otherwise,
/// such a user could make root replace any file.
Result<void> write_signature(const std::string& path, const std::string& signature) {
  std::filesystem::path target = path;
  std::error_code error;
  if (std::filesystem::is_symlink(target, error)) {
    if (const auto writers = os::check_writers(path); !writers)
      return Problem{path, "is a link that takt sign does not follow: " + writers.problems()[0].what,
                     "remove the link"};
    while (std::filesystem::is_symlink(target, error))
      target = target.parent_path() / std::filesystem::read_symlink(target, error);
  }
  return os::replace_file(target.string(), signature, os::Readers::everybody);
}

}  // namespace

Result<void> sign_file(const std::string& file, const std::string& pem) {
  const auto content = read_signed_file(file, kMostSigned, "name an existing file");
  if (!content) return content.problems();
  const Key key = key_from(pem);
  if (key == nullptr) return fail("cannot sign " + file + ": the key is not valid");
  const Digest digest{EVP_MD_CTX_new()};
  std::size_t size = 0;
  TAKT_CHECK(EVP_DigestSignInit(digest.get(), nullptr, EVP_sha256(), nullptr, key.get()) == 1);
  TAKT_CHECK(EVP_DigestSign(digest.get(), nullptr, &size, bytes(*content), content->size()) == 1);
  std::string signature(size, '\0');
  TAKT_CHECK(EVP_DigestSign(digest.get(), reinterpret_cast<unsigned char*>(signature.data()), &size,
                            bytes(*content), content->size()) == 1);
  signature.resize(size);
  return write_signature(signature_of(file), signature);
}

Result<void> check_signer(const std::string& certificate, std::int64_t now) {
  const auto read = signer(certificate, now);
  if (!read) return read.problems();
  return {};
}

Result<void> check_signature(const std::string& file, const os::Fd& copy, const std::string& certificate_file,
                             std::int64_t now) {
  constexpr const char* kSign = "sign it with takt sign";
  const auto certificate = signer(certificate_file, now);
  if (!certificate) return certificate.problems();
  const auto content = read_signed_file(os::path_of(copy), kMostSigned, "name an existing file");
  if (!content) return content.problems();
  auto signature = os::read_file(signature_of(file), kMostPem);
  if (!signature) return signature.problems();
  if (!*signature)
    return Problem{file, "it is not signed, and only signed components are accepted here", kSign};
  const Digest digest{EVP_MD_CTX_new()};
  TAKT_CHECK(EVP_DigestVerifyInit(digest.get(), nullptr, EVP_sha256(), nullptr,
                                  X509_get0_pubkey(certificate->get())) == 1);
  const bool good = EVP_DigestVerify(digest.get(), bytes(**signature), (*signature)->size(), bytes(*content),
                                     content->size()) == 1;
  ERR_clear_error();
  if (good) return {};
  return Problem{
      file, "its signature does not match its contents, or was not made with the key of " + certificate_file,
      "restore the signed file, or sign the changed file"};
}

std::function<Result<void>(const std::string&, const os::Fd&)> signature_check(std::string certificate) {
  return [certificate = std::move(certificate)](const std::string& file, const os::Fd& copy) {
    return check_signature(file, copy, certificate, os::wall_ns() / 1'000'000'000);
  };
}

}  // namespace takt::security
