// Inspects a device's components before the node starts anything of a deployment.
//
// To inspect a component, a process runs foreign constructors, which may crash, hang or print, and loads
// libraries that the node does not need. So a separate process inspects components while the node continues
// its work. This process is takt-node started with TAKT_INSPECT_FD.
#pragma once

#include <memory>

#include <takt/agent/inspection.hpp>
#include <takt/core/result.hpp>

namespace takt::node {

/// Starts a process that inspects components. The destructor of the result ends the process.
Result<std::unique_ptr<agent::Inspection>> inspect(const agent::InspectionRequest& request);

inline constexpr const char* kInspectFd = "TAKT_INSPECT_FD";
/// The main function of the inspection process. Carries out one request and returns the exit status.
int run_inspection();

}  // namespace takt::node
