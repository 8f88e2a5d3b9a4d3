// Prints the node's events on standard error, one per line, for the user at the terminal.
#pragma once

#include <string>
#include <string_view>

namespace takt::node {

/// Prints "14:03:07.250 DEVICE.MODULE: TEXT"; `module` may be empty. Real-time threads must not call this.
void log(std::string_view device, std::string_view module, std::string_view text);

/// From now on, log() prints nothing in this process (`--quiet`). Functions still return their errors to
/// their callers.
void log_nothing();

}  // namespace takt::node
