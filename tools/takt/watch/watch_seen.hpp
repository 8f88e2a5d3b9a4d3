// Makes the snapshots that `takt watch` draws, from the samples that the nodes of a DDS domain publish.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/history.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/wire/cell_state.hpp>

#include "watch/seen.hpp"

namespace takt::tool {

/// Keeps the earlier data that a snapshot needs: transitions, events and descriptors. Only one thread may use
/// an object of this class.
class Watched {
 public:
  explicit Watched(int domain) : domain_(domain) {}

  /// Adds a state transition of a module. Call this once for each transition, in order.
  void add(const LifecycleStatus& status);
  /// Adds a line to the list of events.
  void add(const std::string& event);
  /// Sets the cell of a deployment. If `cell` is null, because the node did not send its descriptor, nothing
  /// changes.
  void add(const std::string& deployment, std::shared_ptr<const model::Cell> cell);

  /// Returns the next device to ask for its descriptor, and notes that the device is being asked. None if no
  /// device needs to be asked now.
  struct Unknown {
    std::string device;
    std::string deployment;
  };
  std::optional<Unknown> unknown(const std::vector<wire::ObservedDevice>& devices, Instant now);

  /// The current state of the domain. A device of the cell that is not found within kFound is shown as lost:
  /// it was lost before this program started, so it publishes nothing.
  watch::Snapshot snapshot(const std::vector<wire::ObservedDevice>& devices, Instant now);
  static constexpr std::chrono::seconds kFound{2};

 private:
  struct Known;
  static void add_missed(watch::Snapshot& snapshot, Known& known,
                         const std::vector<wire::ObservedDevice>& devices, Instant now);

  int domain_;
  client::History history_;
  std::map<std::string, std::vector<watch::Transition>> transitions_;  // by DEVICE.MODULE
  std::deque<std::string> events_;
  struct Known {
    std::shared_ptr<const model::Cell> cell;
    Instant asked{};
    std::map<std::string, Instant>
        missed{};  ///< the devices of the cell that were not found, each with the time of the first search
  };
  std::map<std::string, Known> cells_;  // by deployment
};

}  // namespace takt::tool
