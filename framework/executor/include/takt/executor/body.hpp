// The interface through which an executor calls a thread module.
#pragma once

#include <takt/component.hpp>

namespace takt::executor {

/// The outcome of one call of run() or condition().
struct Outcome {
  ErrorType type = ErrorType::none;
  const char* text = nullptr;  ///< the reason if the call failed; valid until the next call on this thread
  bool finished = false;       ///< true if run() succeeded and the module has finished its work

  constexpr Outcome() = default;
  constexpr Outcome(ErrorType error, const char* why) : type(error), text(why) {}
  /// `failure` is null for success; otherwise it is the reason for the failure.
  constexpr Outcome(const char* failure)  // NOLINT(google-explicit-constructor)
      : type(failure == nullptr ? ErrorType::none : ErrorType::failure), text(failure) {}
  [[nodiscard]] constexpr bool ok() const noexcept { return type == ErrorType::none; }
};

/// The code of a thread module, as the executor calls it. The host implements this interface for loaded
/// modules; tests and the simulation have their own implementations. All functions are called on real-time
/// threads.
class Body {
 public:
  virtual ~Body() = default;
  /// Calls the module's run() once.
  virtual Outcome run(const Cycle& cycle) noexcept = 0;
  /// Evaluates the condition of a sporadic module, and sets `*ready` to true if the module must run.
  /// `cycle.number` is the row number, and `cycle.period` is the basic period of the executor.
  virtual Outcome condition(const Cycle& cycle, bool* ready) noexcept = 0;
  /// Returns true if an event port has an unread sample that is valid at `now`. The executor calls this
  /// function only for modules with immediate dispatch.
  [[nodiscard]] virtual bool has_news(Instant /*now*/) const noexcept { return false; }
  /// Called between two rows, when this body replaces `before`, a body of the same module and type. Takes
  /// over the state of `before`. Returns false, and changes nothing, if it cannot take over the state now.
  virtual bool take_over(Body& /*before*/) noexcept { return true; }
};

}  // namespace takt::executor
