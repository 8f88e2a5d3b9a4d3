// Stores a node's deployment on disk, so that the node can restore it after a restart.
#pragma once

#include <string>
#include <vector>

#include <takt/agent/memory.hpp>
#include <takt/core/result.hpp>

namespace takt::node {

/// Returns TAKT_STATE_DIR if it is set. Otherwise returns /var/lib/takt for root, and a folder in the home
/// directory (or in XDG_STATE_HOME, if set) for other users.
std::string default_state_folder();

/// The files that store the deployment of one device, and the ids of the deployments that were undeployed
/// last. After a power failure, each file has either the old or the new content, never only a part of it.
class DeploymentFile final : public agent::DeploymentStore {
 public:
  DeploymentFile(const std::string& folder, const std::string& device, int domain);

  Result<void> keep(const agent::Kept& kept) const override;
  [[nodiscard]] Result<agent::Kept> kept() const override;
  Result<void> keep_undeployed(const std::vector<std::string>& ids) const override;
  [[nodiscard]] Result<std::vector<std::string>> undeployed() const override;

  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
  std::string undeployed_path_;
};

}  // namespace takt::node
