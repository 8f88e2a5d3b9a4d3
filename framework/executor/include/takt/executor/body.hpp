// The interface through which an executor calls a thread module.
#pragma once

#include <takt/component.hpp>

namespace takt::executor {

/// The outcome of a call of a module's function.
struct Outcome {
  ErrorType type = ErrorType::none;
  const char* text = nullptr;  ///< why the call failed; valid until the next call on this thread

  constexpr Outcome() = default;
  constexpr Outcome(ErrorType error, const char* why) : type(error), text(why) {}
  /// Null means success; a text means failure and gives the reason.
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
  /// Runs the module once.
  virtual Outcome run(const Cycle& cycle) noexcept = 0;
  /// Evaluates the condition of a sporadic module, and sets `*ready` to true if the module must run. `number`
  /// and `period` of the cycle are those of the executor's rows.
  virtual Outcome condition(const Cycle& cycle, bool* ready) noexcept = 0;
  /// Returns true if an event port has an unread sample that is valid at `now`. The executor calls this only
  /// for modules with immediate dispatch.
  [[nodiscard]] virtual bool has_news(Instant /*now*/) const noexcept { return false; }
  /// Replaces `before`, a body of the same module and type, between two rows, and takes over its state.
  /// Returns false if this is not possible now; then nothing has changed.
  virtual bool take_over(Body& /*before*/) noexcept { return true; }
};

}  // namespace takt::executor
