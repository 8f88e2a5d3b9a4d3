// Inspects a device's components before anything of a deployment is started.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/ports.hpp>

namespace takt::agent {

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
  std::vector<std::string> paths;           ///< the component of each module
  std::vector<model::ModulePorts> ports{};  ///< of the device's modules
  std::string description{};                ///< JSON, if asked for: {"device", "modules": [{"name", "path",
                                            ///< "properties": [...], "ports": [...], ...}]}
};

/// An inspection in progress.
class Inspection {
 public:
  virtual ~Inspection() = default;
  /// None until the inspection is finished; does not wait.
  virtual std::optional<Result<Inspected>> result() = 0;

 protected:
  Inspection() = default;
  Inspection(const Inspection&) = default;
  Inspection& operator=(const Inspection&) = default;
};

}  // namespace takt::agent
