#include <takt/security/revocations.hpp>

#include <takt/os/files.hpp>
#include <takt/security/identity.hpp>
#include "pki.hpp"

namespace takt::security {

namespace {

constexpr std::size_t kMostBytes = std::size_t{16} << 20;

template <class Object>
Object read(const std::string& file, Object (*from)(std::string_view)) {
  const auto content = os::read_file(file, kMostBytes);
  return content && *content ? from(**content) : Object{};
}

}  // namespace

Result<void> Revocations::update() {
  const std::string file = folder_ + "/" + kRevoked;
  std::error_code error;
  const auto changed = std::filesystem::last_write_time(file, error);
  if (error || changed == read_) return {};
  const auto crl = read<Crl>(file, crl_from);
  const auto authority = read<Certificate>(folder_ + "/" + kIdentityAuthority, certificate_from);
  if (crl != nullptr && authority != nullptr && is_signed_by(*crl, *authority)) {
    serials_ = serials_in(*crl);
    read_ = changed;
    tried_ = 0;
    return {};
  }
  if (std::exchange(bad_, changed) != changed) tried_ = 0;
  if (++tried_ != kTries) return {};
  return Problem{
      file, "it is not a list that the authority of this identity has signed, so the earlier list applies",
      "copy crl.pem again from the machine of the authority"};
}

}  // namespace takt::security
