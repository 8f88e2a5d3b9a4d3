// Inspects a device's components before anything of a deployment is started.
//
// Inspecting a component runs foreign constructors, which may crash, hang or print, and loads libraries that
// the node does not need. So a separate process does it (takt-node, started with TAKT_INSPECT_FD) while the
// node goes on working.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include <takt/core/result.hpp>
#include <takt/host/inspect.hpp>
#include <takt/os/fd.hpp>

namespace takt::node {

struct InspectionRequest {
  std::string text;  ///< of the descriptor
  std::string file;  ///< its name, for messages
  std::string device;
  bool as_written = false;  ///< use the paths of files as written, relative to the working directory; false:
                            ///< search for the file name on the component path
  bool describe = false;    ///< also describe properties and hooks, which takes longer
  std::string only{};       ///< inspect only this module, without connections; empty: all modules
  std::map<std::string, std::string> swapped{};  ///< by module: the file that replaces the descriptor's
};

struct Inspected {
  host::ComponentPaths paths;
  std::vector<model::ModulePorts> ports{};  ///< of the device's modules
  std::string description{};                ///< JSON, if asked for: {"device", "modules": [{"name", "path",
                                            ///< "properties": [...], "ports": [...], ...}]}
};

class Inspection {
 public:
  virtual ~Inspection() = default;
  /// None until the inspection is finished; does not wait.
  virtual std::optional<Result<Inspected>> result() = 0;
  /// Becomes readable when there may be a result.
  [[nodiscard]] virtual const os::Fd& fd() const noexcept = 0;

 protected:
  Inspection() = default;
  Inspection(const Inspection&) = default;
  Inspection& operator=(const Inspection&) = default;
};

/// Starts the inspection process. Destroying the result ends that process.
Result<std::unique_ptr<Inspection>> inspect(const InspectionRequest& request);

inline constexpr const char* kInspectFd = "TAKT_INSPECT_FD";
/// The main function of the inspection process: serves one request and returns the exit status.
int run_inspection();

}  // namespace takt::node
