// The program takt-node, which manages one device of a cell.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::node {

/// The environment variable with a file descriptor that `takt run` keeps open as long as it runs. When the
/// descriptor closes, the nodes that `takt run` started shut down.
inline constexpr const char* kLifetimeFd = "TAKT_LIFETIME_FD";

/// If this environment variable is set, `takt-node` only tries the rights for real time. Its exit status is 0
/// if it has them, and 1 if not. `takt doctor` starts it, because the file of takt-node may have
/// capabilities.
inline constexpr const char* kTryRights = "TAKT_TRY_RIGHTS";

struct NodeOptions {
  std::string device;
  int domain = 0;
  model::Discovery discovery;
  /// IPv4 addresses of the network interfaces to use; empty for all interfaces.
  std::vector<std::string> interfaces;
  std::string security;  ///< folder of the device's identity; empty for no DDS Security
  /// A certificate; the node uses only components signed with its key. Empty: no signature is needed.
  std::string signed_by;
  std::string state_folder;  ///< folder for files that outlive the node; empty to save nothing
  /// If false, a node that `takt run` started keeps its fault record only in memory.
  bool state_folder_given = false;
  bool resume = false;
  bool require_real_time = false;
  bool check_real_time = false;  ///< true: detect and report real-time violations of modules
  bool quiet = false;
};

/// Runs the node: waits for deployments and runs one at a time. Returns the exit status after SIGTERM, SIGINT
/// or SIGHUP, or after the `takt run` that started the node has ended.
int run_node(const NodeOptions& options);

}  // namespace takt::node
