// The program takt-node, which is the agent of one device on the network.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::node {

/// The environment variable with the file descriptor that takt run keeps open for the nodes that it started.
/// When the descriptor closes, the nodes shut down.
inline constexpr const char* kLifetimeFd = "TAKT_LIFETIME_FD";

struct NodeOptions {
  std::string device;
  int domain = 0;
  model::Discovery discovery;
  std::vector<std::string> interfaces;  ///< IPv4 addresses of the interfaces to use; empty for all
  std::string security;                 ///< folder of the device's identity; empty for no DDS Security
  std::string signed_by;                ///< a certificate; only components signed with its key are used
  std::string state_folder;             ///< empty to save nothing
  bool state_folder_given = false;      ///< if false, a node that takt run started records faults in memory
  bool resume = false;
  bool require_real_time = false;
  bool check_real_time = false;  ///< whether to detect and report real-time violations of modules
  bool quiet = false;
};

/// Runs the node. It waits for deployments and serves one at a time, until SIGTERM, SIGINT or SIGHUP, or
/// until the `takt run` that started the node ends. Returns the exit status.
int run_node(const NodeOptions& options);

}  // namespace takt::node
