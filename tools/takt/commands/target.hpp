// The target of a command, DEVICE or DEVICE.MODULE, as the user has typed it.
#pragma once

#include <string>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/client/connection.hpp>
#include <takt/core/result.hpp>

namespace takt::tool {

struct Target {
  std::string device;
  std::string module{};  ///< empty if the target is a device
};

/// Splits the name of a target. If the target must be a module, `then` is the name of the next argument, for
/// the error message. If the target may be a device, `then` is null.
Result<Target> target_of(const std::string& text, const char* then = nullptr);

/// Splits the name of a module, for a command without another argument.
Result<Target> module_of(const std::string& text);

/// Connects to the network, and checks that the device exists. `rest` is the part of the name after the
/// device, as for client::find_device().
Result<client::Connection> connect_to_device(const client::Network& network, const std::string& device,
                                             const std::string& rest);

/// Returns the commands that start a module from the beginning, in order. `state` is the module's present
/// state, such as "EXECUTING"; empty if the device has no such module.
std::vector<CommandKind> steps_of_restart(const std::string& state);

}  // namespace takt::tool
