// Checks the device in the name of a module or port that a user has typed.
#pragma once

#include <string>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// Searches for the device of a name such as DEVICE.MODULE; `rest` is the part after the device and its dot,
/// or empty. Fails without further waiting if all nodes on the domain have reported which devices they know,
/// and this device is not among them. The problem suggests a similar name or, if the name has no device, the
/// module that was meant. Succeeds if the device is lost, or if a cell lists it, even if its node is not
/// found. The function waits, so a real-time thread must not call it.
Result<void> find_device(Operator& sender, const std::string& device, const std::string& rest);

}  // namespace takt::client
