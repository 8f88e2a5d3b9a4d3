// Makes this program accept only signed components.
#pragma once

namespace takt::tool {

/// If the environment variable TAKT_SIGNED_BY names a certificate, this process from now on rejects every
/// component that is not signed with its key. Call this function before the process starts other threads.
void require_signatures();

}  // namespace takt::tool
