// Makes this program accept only signed components.
#pragma once

namespace takt::tool {

/// If TAKT_SIGNED_BY names a certificate, rejects all components that are not signed with its key from now
/// on. Call it while the process has only one thread.
void require_signatures();

}  // namespace takt::tool
