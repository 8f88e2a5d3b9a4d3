// Reads the `enable` input of a module that moves something.
#pragma once

#include <takt/component.hpp>

#include <chrono>

#include <basic.hpp>

namespace common {

/// Returns the last value of `enable`, or true if no value has arrived yet. With a `timeout` (s, above 0),
/// returns false if the value is older than the timeout or has not arrived yet. Call this in run(); it is
/// real-time capable.
inline bool is_enabled(const takt::InPort<basic::Flag>& enable, double timeout) noexcept {
  const bool heard = timeout <= 0 || enable.age() <= std::chrono::duration<double>(timeout);
  return heard && (!enable.has_value() || enable.value().value());
}

}  // namespace common
