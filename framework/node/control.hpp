// What `takt run` and the nodes that it starts say to each other: JSON texts over a message socket.
//
//   node -> takt   {"event": "ready"}                                       every module is in START
//                  {"event": "ended", "report": {...}, "failures": [...]}   last message
//   takt -> node   {"do": "go", "t0": ns}     {"do": "stop"}
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace takt::node {

inline constexpr const char* kControlFd = "TAKT_CONTROL_FD";

struct NodeOptions {
  std::string device;
  std::string file;
  bool require_real_time = false;
  bool quiet = false;
};

/// The program takt-node: brings up one device of a descriptor, runs it until it is told to stop (by its
/// control socket, by SIGTERM or SIGINT, or by the end of whoever started it), and takes it down. Returns the
/// exit status.
int run_node(const NodeOptions& options);

}  // namespace takt::node
