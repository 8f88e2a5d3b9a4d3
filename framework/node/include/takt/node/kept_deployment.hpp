// Stores a node's deployment on disk, so that the node can restore it after a restart.
#pragma once

#include <optional>
#include <string>

#include <takt/agent/memory.hpp>
#include <takt/core/result.hpp>

namespace takt::node {

/// Returns TAKT_STATE_DIR if it is set, else "/var/lib/takt" for root, and a folder in the home directory for
/// other users.
std::string default_state_folder();

/// The file with the deployment of one device. A power failure leaves the old or the new content, never a
/// part.
class DeploymentFile final : public agent::DeploymentStore {
 public:
  DeploymentFile(const std::string& folder, const std::string& device, int domain);

  Result<void> keep(const agent::KeptDeployment& deployment) const override;
  [[nodiscard]] Result<std::optional<agent::KeptDeployment>> kept() const override;
  Result<void> forget() const override;

  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
};

}  // namespace takt::node
