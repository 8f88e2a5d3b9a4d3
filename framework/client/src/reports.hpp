// Collects the reports of the devices of a domain about themselves and each other.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// The collected reports. A program that joins a domain discovers the nodes one after the other, and more
/// slowly with DDS Security or under load. So the program cannot know from discovery alone when it has found
/// all nodes. Each report names the devices of the node's cell and the nodes that this node has discovered.
/// So the search can end as soon as all these devices and nodes have answered, and the program knows the name
/// of each device that does not answer.
struct Reports {
  std::map<std::string, nlohmann::ordered_json> nodes;  ///< reports of the nodes that answered, by node id
  std::map<std::string, nlohmann::ordered_json> lost;   ///< the last known state of each lost device
  std::set<std::string> named;  ///< names of all devices in the cells of the answering devices
  std::map<std::string, std::set<std::string>> cells;  ///< names of the devices of each cell
  std::set<std::string> discovered;                    ///< ids of the nodes that the answering nodes have
                                                       ///< discovered
  std::multimap<std::string, std::string> modules;     ///< DEVICE.MODULE of each module, by module name
  bool searching = false;  ///< true: a node has started so recently that it may not know the other nodes yet
  Problems problems;       ///< the reasons why devices did not answer

  /// Returns true if all nodes that the answering nodes have discovered are also known to the observer, and
  /// no node is still searching for other nodes.
  [[nodiscard]] bool complete(const Observer& observer) const;
  /// Returns true if a node of the device has answered.
  [[nodiscard]] bool answered(const std::string& device) const;
  /// Returns the devices that other devices name, but that have not answered and are not in `lost`.
  [[nodiscard]] std::set<std::string> missing() const;
};

/// Asks every node for its report, including nodes that have the same device name. The search for nodes ends
/// when all devices that other devices name are discovered, and at the latest as Operator::search() says. If
/// a device is lost, the search goes on until no new node has been discovered for kQuiet. If `wanted` names a
/// device, the search already ends when this device is discovered, or when another device names it; the
/// reports are then incomplete. Fails if no device is discovered. Not for real-time threads, because the
/// function waits.
Result<Reports> all_reports(Operator& sender, const std::string& wanted = {});

/// Returns the names of the devices whose nodes are alive.
std::set<std::string> alive(const std::vector<wire::ObservedDevice>& seen);

/// Returns a text that lists the discovered devices and the peers whose names cannot be resolved, for the
/// message about a device that was not found.
std::string found_there(const Operator& sender);

}  // namespace takt::client
