// The program takt-node: the agent of one device on the network.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::node {

/// Names the file descriptor that takt run keeps open for the nodes it started: when it closes, they shut
/// down.
inline constexpr const char* kLifetimeFd = "TAKT_LIFETIME_FD";

struct NodeOptions {
  std::string device;
  int domain = 0;
  model::Discovery discovery;
  std::vector<std::string> interfaces;  ///< IPv4 addresses; empty: all
  std::string security;                 ///< folder of the device's identity; empty: without DDS Security
  std::string signed_by;                ///< a certificate: components are used only if signed with its key
  std::string state_folder;             ///< empty: nothing is saved
  bool state_folder_given = false;      ///< false: a node that takt run started records faults in memory
  bool resume = false;
  bool require_real_time = false;
  bool check_real_time = false;  ///< detect, print and report what real-time code must not do in modules
  bool quiet = false;
};

/// Waits for deployments and serves one at a time, until SIGTERM, SIGINT or SIGHUP, or until the takt run
/// that started it ends. Returns the exit status.
int run_node(const NodeOptions& options);

}  // namespace takt::node
