// What a device's components are, looked at before anything of a deployment is started.
//
// Looking at a component runs foreign constructors, which may crash, hang or print, and loads what a node has
// no use for. So a program of its own does it (takt-node, started with TAKT_INSPECT_FD), while the node goes
// on with its work.
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
  bool as_written = false;  ///< files are looked up as they are written, from this folder on; else only by
                            ///< their last part, on the component path
  bool describe = false;    ///< properties and hooks too, which takes longer
  std::string only{};       ///< this module alone, and no connections; empty: all
  std::map<std::string, std::string> swapped{};  ///< files of modules in place of those that the text says
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
  /// None until it is done; does not wait.
  virtual std::optional<Result<Inspected>> result() = 0;
  /// Can be read when there may be something new.
  [[nodiscard]] virtual const os::Fd& fd() const noexcept = 0;

 protected:
  Inspection() = default;
  Inspection(const Inspection&) = default;
  Inspection& operator=(const Inspection&) = default;
};

/// Starts the program. Destroying it ends the program.
Result<std::unique_ptr<Inspection>> inspect(const InspectionRequest& request);

inline constexpr const char* kInspectFd = "TAKT_INSPECT_FD";
/// That program: serves one request and returns the exit status.
int run_inspection();

}  // namespace takt::node
