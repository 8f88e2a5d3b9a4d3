// The program takt-node: the agent of one device on the network.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::node {

/// A descriptor that takt run holds open for the nodes that it started: when it closes, they end in order.
inline constexpr const char* kLifetimeFd = "TAKT_LIFETIME_FD";

struct NodeOptions {
  std::string device;
  int domain = 0;
  model::Discovery discovery;
  std::vector<std::string> interfaces;  ///< IPv4 addresses; empty: all
  std::string security;                 ///< folder of the device's identity; empty: without DDS Security
  std::string signed_by;                ///< a certificate: components are used only if signed with its key
  std::string state_folder;             ///< empty: nothing is kept
  bool state_folder_given = false;      ///< else a node that was lent keeps its fault record in memory
  bool resume = false;
  bool require_real_time = false;
  bool check_real_time = false;  ///< what modules do that no real-time code may is seen, said and reported
  bool quiet = false;
};

/// Waits for deployments, and serves one at a time, until it is told to end by SIGTERM, SIGINT or SIGHUP, or
/// by the end of whoever lent it. Returns the exit status.
int run_node(const NodeOptions& options);

}  // namespace takt::node
