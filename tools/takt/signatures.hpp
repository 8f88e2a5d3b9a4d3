// Makes this program accept only signed components.
#pragma once

namespace takt::tool {

/// If TAKT_SIGNED_BY names a certificate, this process rejects all components not signed with the
/// certificate's key from now on. Call this function before the process starts other threads.
void require_signatures();

}  // namespace takt::tool
