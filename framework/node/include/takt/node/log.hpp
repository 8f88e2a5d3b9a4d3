// What a node tells the person at its terminal: one event a line, on standard error.
#pragma once

#include <string>
#include <string_view>

namespace takt::node {

/// "14:03:07.250 DEVICE.MODULE: TEXT"; `module` may be empty. Not for real-time threads.
void log(std::string_view device, std::string_view module, std::string_view text);

/// Silences log() for the whole process (--quiet). Errors are still said by who returns them.
void log_nothing();

}  // namespace takt::node
