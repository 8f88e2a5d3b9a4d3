// The real-time process of one device: its executors and thread modules. It carries out the requests of its
// node, publishes through the channel, and ends when its node is gone.
#pragma once

namespace takt::host {

/// Runs the program takt-host. The file descriptors of its socket and of the channel are in the environment
/// variables TAKT_NODE_FD and TAKT_CHANNEL_FD. Returns the exit status.
int run_host();

}  // namespace takt::host
