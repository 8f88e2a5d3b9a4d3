// Prints the node's events for the user at the terminal, one per line, on standard error.
#pragma once

#include <string>
#include <string_view>

namespace takt::node {

/// Prints "14:03:07.250 DEVICE.MODULE: TEXT"; `module` may be empty. Real-time threads must not call this.
void log(std::string_view device, std::string_view module, std::string_view text);

/// Makes log() print nothing in this process, for --quiet. Functions still return their errors to the caller.
void log_nothing();

}  // namespace takt::node
