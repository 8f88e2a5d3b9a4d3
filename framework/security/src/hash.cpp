#include <takt/security/hash.hpp>

#include <array>
#include <span>

#include <openssl/evp.h>

#include <takt/core/check.hpp>
#include <takt/core/hex.hpp>
#include <takt/os/files.hpp>
#include <takt/security/signature.hpp>

namespace takt::security {

std::string short_hash(const std::string& file) {
  const auto content = os::read_file(file, kMostSigned);
  if (!content || !*content) return "";
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  const std::string& bytes = **content;
  TAKT_CHECK(EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha256(), nullptr) == 1);
  return in_hex(std::as_bytes(std::span{digest}).first(4));
}

}  // namespace takt::security
