// Interface for the inspection of a device's components, which happens before a deployment starts anything.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/build.hpp>
#include <takt/model/ports.hpp>

namespace takt::agent {

struct InspectionRequest {
  std::string text;  ///< the content of the descriptor
  std::string file;  ///< the descriptor's name, for messages
  std::string device;
  bool as_written = false;  ///< true: a component may be anywhere on this machine; false: only on the
                            ///< component path of this device
  bool describe = false;    ///< true: also describe properties and hooks, which takes longer
  std::string only{};       ///< inspect only this module, without connections; empty for all modules
  std::map<std::string, std::string> swapped{};  ///< by module: the component that replaces the one in the
                                                 ///< descriptor
};

struct Inspected {
  std::vector<std::string> paths;           ///< path of the component of each module
  std::vector<model::ModulePorts> ports{};  ///< the ports of the device's modules
  std::vector<model::Build> builds{};       ///< the build of each module's component
  std::string description{};                ///< JSON, if requested: {"device", "modules": [{"name", "path",
                                            ///< "properties": [...], "ports": [...], ...}]}
};

/// An inspection in progress.
class Inspection {
 public:
  virtual ~Inspection() = default;
  /// Returns the result; nothing while the inspection is in progress. Does not wait.
  virtual std::optional<Result<Inspected>> result() = 0;

 protected:
  Inspection() = default;
  Inspection(const Inspection&) = default;
  Inspection& operator=(const Inspection&) = default;
};

}  // namespace takt::agent
