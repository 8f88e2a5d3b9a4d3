// What Fast DDS says of itself.
#pragma once

#include <functional>
#include <string>

namespace takt::dds {

/// From now on its errors go to standard error, one a line; by itself it prints them, in colour, among what a
/// program prints for others to read. Of many that come together the first are shown and the others counted.
void log_to_standard_error();
/// `look` is shown each message first, on the log's own thread; one that it takes (true) is not printed.
/// Null: nobody looks. On return the one before is not called any more.
void look_at_log(std::function<bool(const std::string& message)> look);

}  // namespace takt::dds
