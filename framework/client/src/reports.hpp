// Collects what the devices of a domain report about themselves and each other.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// The collected reports. A program that joins a domain discovers the nodes one after the other, and more
/// slowly with DDS Security or under load. So it cannot know from discovery alone when it has found all
/// nodes. Each report names the devices of the node's cell and the nodes that this node has discovered. So
/// the search can end as soon as all these have answered, and a device that does not answer is known by name.
struct Reports {
  std::map<std::string, nlohmann::ordered_json> devices;  ///< reports of the devices that answered
  std::map<std::string, nlohmann::ordered_json> lost;     ///< the last known state of each lost device
  std::set<std::string> named;  ///< names of all devices in the cells of the answering devices
  std::set<std::string> heard;                            ///< ids of the nodes that the answering nodes have
                                                          ///< discovered
  bool searching = false;                                 ///< whether a node started so recently that it may
                                                          ///< not know the other nodes yet
  Problems problems;                                      ///< why devices did not answer

  /// The devices that other devices name, but that have neither answered nor been reported as lost.
  [[nodiscard]] std::set<std::string> missing() const;
};

/// Asks every device for its report. Waits at most `limit` for each device that other devices name and that
/// is not discovered yet. If a device is lost, the search goes on until no new node has been discovered for
/// kQuiet. Fails if no device is discovered within `limit`. Waits, so a real-time thread must not call this.
Result<Reports> all_reports(Operator& asker, Nanoseconds limit);

/// The names of the devices whose nodes are alive.
std::set<std::string> alive(const std::vector<wire::ObservedDevice>& seen);

}  // namespace takt::client
