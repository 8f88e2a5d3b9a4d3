// The real-time process of one device: its executors and thread modules. It does what its node asks,
// publishes through the channel, and ends when its node is gone.
#pragma once

namespace takt::host {

/// The program takt-host: finds its end of the socket and the channel in the environment (TAKT_NODE_FD,
/// TAKT_CHANNEL_FD). Returns the exit status.
int run_host();

}  // namespace takt::host
