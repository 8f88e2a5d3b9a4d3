// Makes the snapshots for the screen of `takt watch` from what the nodes of a domain publish.
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

/// Keeps the data that snapshots need from earlier: transitions, events and descriptors. For one thread only.
class Watched {
 public:
  explicit Watched(int domain) : domain_(domain) {}

  /// Adds a transition. Call it for every transition, in order.
  void add(const LifecycleStatus& status);
  /// Adds a line to the list of events.
  void add(const std::string& event);
  /// Sets the cell of a deployment. Null means that the node did not send its descriptor; then nothing
  /// changes.
  void add(const std::string& deployment, std::shared_ptr<const model::Cell> cell);

  /// The next device to ask for its descriptor. The device then counts as asked.
  struct Unknown {
    std::string device;
    std::string deployment;
  };
  std::optional<Unknown> unknown(const std::vector<wire::ObservedDevice>& devices, Instant now);

  /// The state of the domain now. A device that was lost before this program started no longer publishes
  /// anything. Such a device is shown as lost if it is not found within kFound.
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
    std::map<std::string, Instant> missed{};  ///< devices of the cell that are not found, and since when
  };
  std::map<std::string, Known> cells_;  // by deployment
};

}  // namespace takt::tool
