// A thread module as its executor sees it.
#pragma once

#include <takt/component/component.hpp>

namespace takt::executor {

/// Implemented by the host for what it has loaded, and by tests and simulation. Real-time.
class Body {
 public:
  virtual ~Body() = default;
  /// One run(). Null when it went well; else why not, in a text that is valid until the next call on this
  /// thread.
  virtual const char* run(const Cycle& cycle) noexcept = 0;
  /// Whether a sporadic module is to run. Null and false in `*ready` when not; a text when it failed.
  virtual const char* condition(bool* ready) noexcept = 0;
};

}  // namespace takt::executor
