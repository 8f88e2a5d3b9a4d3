// What Fast DDS says of itself.
#pragma once

namespace takt::dds {

/// From now on its errors go to standard error, one a line; by itself it prints them, in colour, among what a
/// program prints for others to read. Of many that come together the first are shown and the others counted.
void log_to_standard_error();

}  // namespace takt::dds
