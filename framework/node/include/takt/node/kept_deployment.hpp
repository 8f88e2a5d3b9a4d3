// Stores a node's deployment on disk, so that the node can restore it after a restart.
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
  std::int64_t t0_ns = 0;  ///< T0 on the wall clock, which may have been set since
  /// os::boot_id() when t0_monotonic_ns was read, which is valid until the next boot. Empty: not known.
  std::string boot{};
  std::int64_t t0_monotonic_ns = 0;
  std::string safe{};  ///< the safe values of the cell's outputs, in the format of model::parse_safe()
  bool operator==(const KeptDeployment&) const = default;
};

/// TAKT_STATE_DIR if it is set, else "/var/lib/takt" for root and a folder in the home of other users.
std::string default_state_folder();

/// The file of one device. A power failure leaves the old content or the new one, never a part.
class DeploymentFile {
 public:
  DeploymentFile() = default;
  DeploymentFile(const std::string& folder, const std::string& device, int domain);

  Result<void> keep(const KeptDeployment& deployment) const;
  /// None if there is no file. Fails if the file is damaged or cannot be read.
  [[nodiscard]] Result<std::optional<KeptDeployment>> kept() const;
  Result<void> forget() const;

  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
};

}  // namespace takt::node
