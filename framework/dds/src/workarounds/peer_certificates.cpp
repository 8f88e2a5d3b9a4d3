#include "peer_certificates.hpp"

#include <mutex>
#include <utility>

#include <fastdds/rtps/common/Guid.h>
#include <fastdds/rtps/security/accesscontrol/AccessControl.h>
#include <fastdds/rtps/security/common/Handle.h>
#include "replaced_function.hpp"

namespace eprosima::fastrtps::rtps::security {

// Fast DDS does not install the header of this class, which checks the permissions of a participant at the
// end of its authentication.
class Permissions {
 public:
  PermissionsHandle* validate_remote_permissions(Authentication& authentication, const IdentityHandle& own,
                                                 const PermissionsHandle& own_permissions,
                                                 const IdentityHandle& other, const PermissionsToken& token,
                                                 const PermissionsCredentialToken& credential,
                                                 SecurityException& exception);
};

}  // namespace eprosima::fastrtps::rtps::security

namespace {

namespace rtps = eprosima::fastrtps::rtps;
namespace security = eprosima::fastrtps::rtps::security;

using Validate = security::PermissionsHandle*(security::Permissions*, security::Authentication&,
                                              const security::IdentityHandle&,
                                              const security::PermissionsHandle&,
                                              const security::IdentityHandle&, const rtps::PermissionsToken&,
                                              const rtps::PermissionsCredentialToken&,
                                              security::SecurityException&);

Validate* original() noexcept {
  static Validate* const found = takt::dds::replaced<Validate>(
      "_ZN8eprosima8fastrtps4rtps8security11Permissions27validate_remote_permissionsERNS2_"
      "14AuthenticationERKNS2_6HandleES8_S8_RKNS1_10DataHolderESB_RNS2_17SecurityExceptionE");
  return found;
}

// The first members of the identity of another participant, in the layout of Fast DDS 2.9.
struct OtherIdentity {
  [[maybe_unused]] static const char* const class_id_;
  void* store;
  x509_st* certificate;
  void* key;
  rtps::GUID_t participant;
};
using OtherIdentityHandle = security::HandleImpl<OtherIdentity, void>;

std::mutex looker_mutex;
std::function<void(const rtps::GuidPrefix_t&, const x509_st&)> looker;

}  // namespace

namespace takt::dds {

void look_at_certificates(std::function<void(const rtps::GuidPrefix_t&, const x509_st&)> seen) {
  static_cast<void>(original());
  const std::lock_guard lock{looker_mutex};
  looker = std::move(seen);
}

}  // namespace takt::dds

namespace eprosima::fastrtps::rtps::security {

PermissionsHandle* Permissions::validate_remote_permissions(
    Authentication& authentication, const IdentityHandle& own, const PermissionsHandle& own_permissions,
    const IdentityHandle& other, const PermissionsToken& token, const PermissionsCredentialToken& credential,
    SecurityException& exception) {
  PermissionsHandle* const permissions =
      original()(this, authentication, own, own_permissions, other, token, credential, exception);
  if (permissions == nullptr || permissions->nil()) return permissions;
  const OtherIdentity& identity = *reinterpret_cast<const OtherIdentityHandle&>(other).operator->();
  const std::lock_guard lock{looker_mutex};
  if (looker && identity.certificate != nullptr)
    looker(identity.participant.guidPrefix, *identity.certificate);
  return permissions;
}

}  // namespace eprosima::fastrtps::rtps::security
