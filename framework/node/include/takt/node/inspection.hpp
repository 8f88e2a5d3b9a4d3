// Inspects a device's components before anything of a deployment is started.
//
// Inspecting a component runs foreign constructors, which may crash, hang or print, and loads libraries that
// the node does not need. So a separate process inspects components while the node continues its work. This
// process is takt-node started with TAKT_INSPECT_FD.
#pragma once

#include <memory>

#include <takt/agent/inspection.hpp>
#include <takt/core/result.hpp>

namespace takt::node {

/// Starts the inspection process. Destroying the result ends the process.
Result<std::unique_ptr<agent::Inspection>> inspect(const agent::InspectionRequest& request);

inline constexpr const char* kInspectFd = "TAKT_INSPECT_FD";
/// The main function of the inspection process. Serves one request and returns the exit status.
int run_inspection();

}  // namespace takt::node
