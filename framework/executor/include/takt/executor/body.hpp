// The interface through which an executor calls a thread module.
#pragma once

#include <takt/component.hpp>

namespace takt::executor {

/// The outcome of a module call.
struct Outcome {
  ErrorType type = ErrorType::none;
  const char* text = nullptr;  ///< the reason of an error; valid until the next call on this thread

  constexpr Outcome() = default;
  constexpr Outcome(ErrorType error, const char* why) : type(error), text(why) {}
  /// Null means success; a text means a failure.
  constexpr Outcome(const char* failure)  // NOLINT(google-explicit-constructor)
      : type(failure == nullptr ? ErrorType::none : ErrorType::failure), text(failure) {}
  [[nodiscard]] constexpr bool ok() const noexcept { return type == ErrorType::none; }
};

/// The host implements this for loaded modules; tests and the simulation have their own implementations. All
/// functions are called on real-time threads.
class Body {
 public:
  virtual ~Body() = default;
  /// Runs the module once.
  virtual Outcome run(const Cycle& cycle) noexcept = 0;
  /// Sets `*ready` to whether a sporadic module is to run. `number` and `period` of the cycle are those of
  /// the executor's rows.
  virtual Outcome condition(const Cycle& cycle, bool* ready) noexcept = 0;
  /// Whether an event port has an unread sample that is valid at `now`. Called for modules with immediate
  /// dispatch.
  [[nodiscard]] virtual bool has_news(Instant /*now*/) const noexcept { return false; }
  /// Replaces `before`, a body of the same module and kind, between two rows, and continues from its state.
  /// Returns false if this is not possible now; then nothing has changed.
  virtual bool take_over(Body& /*before*/) noexcept { return true; }
};

}  // namespace takt::executor
