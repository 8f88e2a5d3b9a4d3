#include "peer_certificates.hpp"

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "replaced_function.hpp"

#define VALIDATE                                                                                         \
  TAKT_RTPS                                                                                              \
  "8security11Permissions27validate_remote_permissionsERNS2_14AuthenticationERKNS2_6HandleES8_S8_RKNS1_" \
  "10DataHolderESB_RNS2_17SecurityExceptionE"

namespace takt::dds {

namespace {

/// A handle of Fast DDS for something that a plugin has made.
template <class Content>
struct Handle : std::enable_shared_from_this<Handle<Content>> {
  virtual ~Handle() = default;
  std::string kind;
  Content* content = nullptr;
};

/// How the identity of another participant begins.
struct OtherIdentity {
  void* store;
  x509_st* certificate;
  void* key;
  rtps::GUID_t participant;
};

// Checks the permissions of another participant at the end of its authentication.
using Validate = void*(void* permissions, void* authentication, const void* own, const void* own_permissions,
                       const void* other, const void* token, const void* credential, void* exception);

Validate* original() noexcept {
  static Validate* const found = replaced<Validate>(VALIDATE);
  return found;
}

std::mutex looker_mutex;
std::function<void(const rtps::GuidPrefix_t&, const x509_st&)> looker;

}  // namespace

void look_at_certificates(std::function<void(const rtps::GuidPrefix_t&, const x509_st&)> seen) {
  static_cast<void>(original());
  const std::lock_guard lock{looker_mutex};
  looker = std::move(seen);
}

Validate validate_permissions asm(VALIDATE);

void* validate_permissions(void* permissions, void* authentication, const void* own,
                           const void* own_permissions, const void* other, const void* token,
                           const void* credential, void* exception) {
  void* const valid =
      original()(permissions, authentication, own, own_permissions, other, token, credential, exception);
  if (valid == nullptr || static_cast<const Handle<void>*>(valid)->content == nullptr) return valid;
  const OtherIdentity& identity = *static_cast<const Handle<OtherIdentity>*>(other)->content;
  const std::lock_guard lock{looker_mutex};
  if (looker && identity.certificate != nullptr)
    looker(identity.participant.guidPrefix, *identity.certificate);
  return valid;
}

}  // namespace takt::dds
