// The deployment that a node has on disk, so that it can take it up again after a restart.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::node {

struct KeptDeployment {
  std::string id;
  std::string file;  ///< the descriptor's name, for messages
  std::string text;  ///< of the descriptor
  bool require_real_time = false;
  std::int64_t t0_ns = 0;  ///< of the wall clock, which may have been set since
  /// The same of the monotonic clock, which goes on until the machine is started again: os::boot_id() of
  /// then. Empty: not known.
  std::string boot{};
  std::int64_t t0_monotonic_ns = 0;
  std::string safe{};  ///< the safe values of the cell's outputs, as model::parse_safe() reads them
  bool operator==(const KeptDeployment&) const = default;
};

/// "/var/lib/takt", or for a user who is not root a folder of his own; TAKT_STATE_DIR instead where it is
/// set.
std::string default_state_folder();

/// The file of one device. All of it is there or nothing, whenever the power went.
class DeploymentFile {
 public:
  DeploymentFile() = default;
  DeploymentFile(const std::string& folder, const std::string& device, int domain);

  Result<void> keep(const KeptDeployment& deployment) const;
  /// None where there is no file. Fails on one that cannot be read, or is damaged.
  [[nodiscard]] Result<std::optional<KeptDeployment>> kept() const;
  Result<void> forget() const;

  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
};

}  // namespace takt::node
