// takt-host, the real-time process: it runs executors and thread modules of one device. It carries out the
// requests of its node, reports through the channel (the shared memory of the device), and ends when its node
// has ended.
#pragma once

namespace takt::host {

/// Runs the program takt-host. The environment variables TAKT_NODE_FD, TAKT_CHANNEL_FD and TAKT_FLIGHT_FD
/// give the file descriptors of the socket to the node, of the channel and of the flight record. Returns the
/// exit status.
int run_host();

/// If the calling thread is in a hook, reports that its module ends this process, so that the node does not
/// look for another cause. takt-host calls it before each call of _exit(). Async-signal-safe.
void report_exit() noexcept;

}  // namespace takt::host
