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
  std::string text;  ///< the content of the descriptor
  std::string file;  ///< the descriptor's name, for messages
  std::string device;
  bool as_written = false;  ///< if true, uses the paths of files as written, relative to the working
                            ///< directory; if false, searches the component path for the file name
  bool describe = false;    ///< whether to describe properties and hooks too, which takes longer
  std::string only{};       ///< inspect only this module, without connections; empty for all modules
  std::map<std::string, std::string> swapped{};  ///< by module: the file that replaces the one in the
                                                 ///< descriptor
};

struct Inspected {
  std::vector<std::string> paths;           ///< the component of each module
  std::vector<model::ModulePorts> ports{};  ///< the ports of the device's modules
  std::string description{};                ///< JSON, if requested: {"device", "modules": [{"name", "path",
                                            ///< "properties": [...], "ports": [...], ...}]}
};

/// An inspection in progress.
class Inspection {
 public:
  virtual ~Inspection() = default;
  /// Returns nothing until the inspection is finished. Does not wait.
  virtual std::optional<Result<Inspected>> result() = 0;

 protected:
  Inspection() = default;
  Inspection(const Inspection&) = default;
  Inspection& operator=(const Inspection&) = default;
};

}  // namespace takt::agent
