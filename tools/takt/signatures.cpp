#include "signatures.hpp"

#include <takt/host/component_path.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>
#include <takt/security/signature.hpp>

namespace takt::tool {

void require_signatures() {
  const std::string certificate = os::environment("TAKT_SIGNED_BY");
  if (certificate.empty()) return;
  host::require_of_components([certificate](const std::string& file) {
    return security::check_signature(file, certificate, os::wall_ns() / 1'000'000'000);
  });
}

}  // namespace takt::tool
