// Prints the node's events for the person at its terminal: one line each, on standard error.
#pragma once

#include <string>
#include <string_view>

namespace takt::node {

/// Prints "14:03:07.250 DEVICE.MODULE: TEXT"; `module` may be empty. Not for real-time threads.
void log(std::string_view device, std::string_view module, std::string_view text);

/// Silences log() for the whole process (--quiet). Callers still report errors by their return values.
void log_nothing();

}  // namespace takt::node
