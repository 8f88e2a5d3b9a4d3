// Collects what the devices of a domain report about themselves and each other.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// A program that joins a domain discovers its nodes one after the other, and late under security or load.
/// Each report names the devices of the node's cell and the nodes that the node receives. So the search can
/// end as soon as all of them have answered, and no device is left out silently.
struct Reports {
  std::map<std::string, nlohmann::ordered_json> devices;  ///< of the devices that answered
  std::map<std::string, nlohmann::ordered_json> lost;     ///< the last known state of each lost device
  std::set<std::string> named;                            ///< every device of the cells that were found
  std::set<std::string> heard;                            ///< ids of the nodes that other nodes receive
  bool searching = false;                                 ///< some node is too new to know the others
  Problems problems;                                      ///< why devices did not answer

  /// Devices that others name, but that neither answered nor were lost.
  [[nodiscard]] std::set<std::string> missing() const;
};

/// Asks every device for its report. Waits at most `limit` for each device that others name and that is not
/// discovered yet. If others have lost a device, the search goes on until nothing new was discovered for
/// kQuiet. Fails if no device is discovered within `limit`. It waits: not for real-time threads.
Result<Reports> all_reports(Operator& asker, Nanoseconds limit);

/// The names of the devices whose nodes are alive.
std::set<std::string> alive(const std::vector<wire::ObservedDevice>& seen);

}  // namespace takt::client
