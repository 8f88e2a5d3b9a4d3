// Interfaces to the data that outlive the node's process: the saved deployment, and the fault record.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/fault.hpp>

namespace takt::agent {

/// A deployment, with the descriptor that the transaction `transaction` gave it.
struct KeptDeployment {
  std::string id;
  std::string transaction;  ///< id of the deployment, or of its last update
  std::string file;         ///< the descriptor's name, for messages
  std::string text;         ///< the content of the descriptor; empty: the update removes this device
  bool require_real_time = false;
  /// The time from which releases are counted, on the wall clock, which may have been set since then. 0: not
  /// known yet.
  std::int64_t t0_ns = 0;
  /// Identifies the boot of the machine during which t0_monotonic_ns is valid. Empty if not known.
  std::string boot{};
  std::int64_t t0_monotonic_ns = 0;
  std::string safe{};  ///< the safe values of the cell's outputs, in the format of model::parse_safe()
  std::vector<std::string> devices{};  ///< the devices that take part in the transaction
  bool operator==(const KeptDeployment&) const = default;
};

/// What a restarted node needs.
struct Kept {
  std::optional<KeptDeployment> current{};  ///< every device of the cell has it, so the node begins it again
  /// The node has undone it by its restart, and begins it only if another device tells that it is final.
  std::optional<KeptDeployment> pending{};
  [[nodiscard]] bool empty() const { return !current && !pending; }
  bool operator==(const Kept&) const = default;
};

/// Saves the deployments that a restarted node can restore, and the ids of the deployments that were
/// undeployed last. A restarted node publishes these ids for devices that missed the undeploy command.
class DeploymentStore {
 public:
  virtual ~DeploymentStore() = default;
  /// Begins to replace what was saved before. Does not wait for the disk.
  virtual void save(const Kept& kept, const std::vector<std::string>& undeployed) = 0;
  /// Returns the result of the last save(), or nothing while it is in progress.
  [[nodiscard]] virtual std::optional<Result<void>> saved() const = 0;
  /// Returns what is saved. Fails if the saved data is damaged or cannot be read.
  [[nodiscard]] virtual Result<Kept> kept() const = 0;
  [[nodiscard]] virtual Result<std::vector<std::string>> undeployed() const = 0;
};

/// The fault record: the device's newest events.
class FaultMemory {
 public:
  virtual ~FaultMemory() = default;
  /// Sets the sequence number of the event, and adds the event to the record.
  virtual void append(model::Fault& fault) = 0;
  /// Makes the record keep the events with these numbers, of which there may be few. Other events are replaced
  /// instead.
  virtual void keep(std::vector<std::uint64_t> numbers) = 0;
  /// If writing to the file failed before, tries to use the file again. Returns true if the file is now in
  /// use again and contains all events that are in memory.
  virtual bool reopen() = 0;
  /// Waits until all events are on disk.
  virtual void sync() const = 0;
  [[nodiscard]] virtual const std::vector<model::Fault>& events() const noexcept = 0;
  /// Number of older events that newer events have replaced.
  [[nodiscard]] virtual std::uint64_t overwritten() const noexcept = 0;
  /// Number of invalid events that were found when the file was read.
  [[nodiscard]] virtual std::uint64_t damaged() const noexcept = 0;
  [[nodiscard]] virtual const Problems& problems() const noexcept = 0;
  /// The path of the file; empty if the events are only in memory.
  [[nodiscard]] virtual const std::string& file() const noexcept = 0;

 protected:
  FaultMemory() = default;
  FaultMemory(const FaultMemory&) = default;
  FaultMemory(FaultMemory&&) = default;
  FaultMemory& operator=(const FaultMemory&) = default;
  FaultMemory& operator=(FaultMemory&&) = default;
};

}  // namespace takt::agent
