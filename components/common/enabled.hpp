// Reads the `enable` input of a module that moves something.
#pragma once

#include <takt/component.hpp>

#include <chrono>

#include <basic.hpp>

namespace common {

/// The last value of `enable`, or true if there is none. With a `timeout` (s, above 0): false if the value is
/// older than that, or if there is none. Real-time, for run().
inline bool is_enabled(const takt::InPort<basic::Flag>& enable, double timeout) noexcept {
  const bool heard = timeout <= 0 || enable.age() <= std::chrono::duration<double>(timeout);
  return heard && (!enable.has_value() || enable.value().value());
}

}  // namespace common
