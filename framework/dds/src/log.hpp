// The log messages of Fast DDS.
#pragma once

#include <functional>
#include <string>

namespace takt::dds {

/// From now on, errors of Fast DDS go to standard error, one per line. By default, Fast DDS prints errors in
/// colour on standard output. If there are many in a short time, the first ones are printed and the others
/// counted.
void log_to_standard_error();
/// From now on, `look` gets each message before it is printed, on the log's own thread. If `look` returns
/// true, the message is not printed. Null removes the function. On return, the previous function is no longer
/// called.
void look_at_log(std::function<bool(const std::string& message)> look);

}  // namespace takt::dds
