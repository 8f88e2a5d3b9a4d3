#include "signatures.hpp"

#include <takt/host/component_path.hpp>
#include <takt/os/environment.hpp>
#include <takt/security/signature.hpp>

namespace takt::tool {

void require_signatures() {
  const std::string certificate = os::environment("TAKT_SIGNED_BY");
  if (!certificate.empty()) host::require_of_components(security::signature_check(certificate));
}

}  // namespace takt::tool
