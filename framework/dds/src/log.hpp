// Redirects and filters the log messages of Fast DDS.
#pragma once

#include <functional>
#include <string>

namespace takt::dds {

/// Makes Fast DDS print its errors on standard error, one per line. By default, Fast DDS prints errors in
/// colour on standard output. Of many errors in a short time, the first ones are printed and the others are
/// only counted.
void log_to_standard_error();
/// Sets a function that Fast DDS calls with each message before it prints the message, on its log thread. If
/// `look` returns true, the message is not printed. A null `look` removes the function. When look_at_log()
/// has returned, the previous function is not called any more.
void look_at_log(std::function<bool(const std::string& message)> look);

}  // namespace takt::dds
