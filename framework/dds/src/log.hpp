// The log messages of Fast DDS.
#pragma once

#include <functional>
#include <string>

namespace takt::dds {

/// From now on errors of Fast DDS go to standard error, one per line. By default it prints them in colour on
/// standard output. If many come together, the first ones are printed and the others are counted.
void log_to_standard_error();
/// `look` gets each message first, on the log's own thread. If it returns true, the message is not printed.
/// Null removes it. On return, the previous function is no longer called.
void look_at_log(std::function<bool(const std::string& message)> look);

}  // namespace takt::dds
