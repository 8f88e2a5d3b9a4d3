// Components that must be signed.
#pragma once

namespace takt::tool {

/// Where TAKT_SIGNED_BY names a certificate, components that are not signed with its key are refused from now
/// on. While there is one thread.
void require_signatures();

}  // namespace takt::tool
