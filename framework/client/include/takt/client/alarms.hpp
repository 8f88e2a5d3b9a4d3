// Reads the alarms of the devices of a domain, and acknowledges them.
#pragma once

#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/model/alarm.hpp>

namespace takt::client {

struct AllAlarms {
  std::vector<model::Alarm> alarms;  ///< the worst first
  Problems problems;                 ///< the reasons why the alarms of other devices are not in `alarms`
};

/// Reads the alarms of all devices of the domain, or only those of one device if `device` is not empty.
AllAlarms read_alarms(Operator& sender, const std::string& device = {});
/// Reads the alarms in the answer of a device. Their texts have no control characters.
Result<std::vector<model::Alarm>> alarms_in(const std::string& device, const std::string& data);

/// Acknowledges the alarms of a module, or of a device and all its modules, and returns them. If `number` is
/// not 0, acknowledges only the alarm with this number.
Result<std::vector<model::Alarm>> acknowledge(Operator& sender, const std::string& device,
                                              const std::string& module, const std::string& note,
                                              std::uint64_t number = 0);

}  // namespace takt::client
