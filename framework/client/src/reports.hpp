// Collects what the devices of a domain report about themselves and each other.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// The collected reports. A program that joins a domain discovers its nodes one after the other, and slowly
/// with DDS Security or under load. Each report names the devices of the node's cell and the nodes that the
/// node receives. So the search can end as soon as all named devices have answered, and no device is left out
/// silently.
struct Reports {
  std::map<std::string, nlohmann::ordered_json> devices;  ///< reports of the devices that answered
  std::map<std::string, nlohmann::ordered_json> lost;     ///< the last known state of each lost device
  std::set<std::string> named;  ///< names of all devices of the cells that were found
  std::set<std::string> heard;                            ///< ids of the nodes that other nodes receive
  bool searching = false;                                 ///< some node is too new to know the others
  Problems problems;                                      ///< why devices did not answer

  /// The devices that other devices name, but that neither answered nor were lost.
  [[nodiscard]] std::set<std::string> missing() const;
};

/// Asks every device for its report. Waits at most `limit` for each device that other devices name and that
/// is not discovered yet. If a device is lost, the search goes on until nothing new was discovered for
/// kQuiet. Fails if no device is discovered within `limit`. Real-time threads must not call this, because it
/// waits.
Result<Reports> all_reports(Operator& asker, Nanoseconds limit);

/// The names of the devices whose nodes are alive.
std::set<std::string> alive(const std::vector<wire::ObservedDevice>& seen);

}  // namespace takt::client
