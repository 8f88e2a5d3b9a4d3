// What the devices of a domain say of themselves, and of each other.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// A program that joins a domain discovers its nodes one after the other, late where there is security or
/// load. Each node's report names the devices of its cell and the nodes that it hears, so the search ends as
/// soon as all of them have answered, and none is left out in silence.
struct Reports {
  std::map<std::string, nlohmann::ordered_json> devices;  ///< of the devices that answered
  std::map<std::string, nlohmann::ordered_json> lost;     ///< the last known state of each lost device
  std::set<std::string> named;                            ///< every device of the cells that were found
  std::set<std::string> heard;                            ///< ids of the nodes that the found nodes hear
  bool searching = false;                                 ///< some node is too new to know the others
  Problems problems;                                      ///< of the devices that did not answer

  /// Devices that others name, and of which nothing is known.
  [[nodiscard]] std::set<std::string> missing() const;
};

/// Asks every device for its report. Devices that others name and that are not discovered yet are waited for,
/// each at most `limit`; for one that others have lost, the search goes on until nothing was discovered for
/// kQuiet. Fails if no device is discovered within `limit`. Not from a real-time thread: it waits.
Result<Reports> all_reports(Operator& asker, Nanoseconds limit);

/// Those of them whose nodes are there.
std::set<std::string> alive(const std::vector<dds::ObservedDevice>& seen);

}  // namespace takt::client
