// Whether who moves something may move.
#pragma once

#include <takt/component.hpp>

#include <chrono>

#include <basic.hpp>

namespace common {

/// What was said last, true before anything was; with a `timeout` (s, above 0) false when that is older, or
/// when nothing was said yet. Real-time, for run().
inline bool is_enabled(const takt::InPort<basic::Flag>& enable, double timeout) noexcept {
  const bool heard = timeout <= 0 || enable.age() <= std::chrono::duration<double>(timeout);
  return heard && (!enable.has_value() || enable.value().value());
}

}  // namespace common
