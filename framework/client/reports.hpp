// What the devices of a domain say of themselves, and of each other.
#pragma once

#include <map>
#include <set>
#include <string>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// Who comes to a domain hears of its devices one after the other, late where there is security or load. What
/// one of them says names the others of its cell, so that none is left out in silence.
struct Reports {
  std::map<std::string, nlohmann::ordered_json> devices;  ///< of those that answered
  std::map<std::string, nlohmann::ordered_json> lost;     ///< what others have heard last of a device
  std::set<std::string> named;                            ///< all of their cells
  Problems problems;                                      ///< those that did not answer, and why

  /// Those that others name, and of which nothing is known.
  [[nodiscard]] std::set<std::string> missing() const;
};

/// Asks every device that there is; those that others name and that are not found yet are waited for. Fails
/// where none is found within `limit`; then as long for the others.
Result<Reports> all_reports(Operator& asker, Nanoseconds limit);

/// Those of them whose nodes are there.
std::set<std::string> alive(const std::vector<dds::SeenDevice>& seen);

}  // namespace takt::client
