// The real-time process of one device: its executors and thread modules. It carries out the requests of its
// node, publishes through the channel, and ends when its node is gone.
#pragma once

namespace takt::host {

/// The program takt-host. It takes its end of the socket and the channel from the environment (TAKT_NODE_FD,
/// TAKT_CHANNEL_FD). Returns the exit status.
int run_host();

}  // namespace takt::host
