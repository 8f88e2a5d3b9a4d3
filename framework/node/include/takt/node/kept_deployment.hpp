// Stores a node's deployment on disk, so that the node can restore it after a restart.
#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/agent/memory.hpp>
#include <takt/core/result.hpp>
#include <takt/node/worker.hpp>

namespace takt::node {

/// Returns TAKT_STATE_DIR if it is set. Otherwise returns /var/lib/takt for root, and a folder in the home
/// directory (or in XDG_STATE_HOME, if set) for other users.
std::string default_state_folder();

/// The files that store the deployment of one device, and the ids of the deployments that were undeployed
/// last. After a power failure, each file has either the old or the new content, never only a part of it.
class DeploymentFile final : public agent::DeploymentStore {
 public:
  DeploymentFile(const std::string& folder, const std::string& device, int domain);

  Result<void> keep(const agent::Kept& kept) const;
  Result<void> keep_undeployed(const std::vector<std::string>& ids) const;
  /// Waits for the disk.
  void save(const agent::Kept& kept, const std::vector<std::string>& undeployed) override;
  [[nodiscard]] std::optional<Result<void>> saved() const override { return saved_; }
  [[nodiscard]] Result<agent::Kept> kept() const override;
  [[nodiscard]] Result<std::vector<std::string>> undeployed() const override;

  [[nodiscard]] const std::string& path() const noexcept { return path_; }

 private:
  std::string path_;
  std::string undeployed_path_;
  std::optional<Result<void>> saved_{};
  std::optional<std::vector<std::string>> undeployed_{};  // the ids in the file, once they are written
};

/// Writes a DeploymentFile on a thread of its own, because a disk may take long to answer. Several calls of
/// save() during one write lead to one further write.
class DeploymentWriter final : public agent::DeploymentStore {
 public:
  /// Fails if the system denies a thread.
  static Result<std::shared_ptr<DeploymentWriter>> create(DeploymentFile file);

  void save(const agent::Kept& kept, const std::vector<std::string>& undeployed) override;
  [[nodiscard]] std::optional<Result<void>> saved() const override;
  [[nodiscard]] Result<agent::Kept> kept() const override { return shared_->file.kept(); }
  [[nodiscard]] Result<std::vector<std::string>> undeployed() const override {
    return shared_->file.undeployed();
  }

 private:
  struct Next {
    agent::Kept kept;
    std::vector<std::string> undeployed;
  };
  struct Shared {
    explicit Shared(DeploymentFile its_file) : file(std::move(its_file)) {}
    DeploymentFile file;  // only the worker writes it
    std::mutex mutex{};   // never held during a write
    std::optional<Next> next{};
    std::optional<Result<void>> saved{};
  };
  DeploymentWriter(DeploymentFile file, std::unique_ptr<Worker> worker);

  std::shared_ptr<Shared> shared_;
  std::unique_ptr<Worker> worker_;
};

}  // namespace takt::node
