// Redirects and filters the log messages of Fast DDS.
#pragma once

#include <functional>
#include <string>

namespace takt::dds {

/// Makes Fast DDS print its errors on standard error, one per line. By default, Fast DDS prints errors in
/// colour on standard output. In each interval of ten seconds, prints at most ten errors, and then the number
/// of the omitted errors. Also omits errors that standard error does not take at once, because nothing reads
/// it.
void log_to_standard_error();
/// Sets a function that the log thread of Fast DDS calls with each message before the message is printed. If
/// `look` returns true, the message is not printed. A null `look` removes the function. When look_at_log()
/// has returned, the previous function is not called any more.
void look_at_log(std::function<bool(const std::string& message)> look);

}  // namespace takt::dds
