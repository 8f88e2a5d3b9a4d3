// A thread module as its executor sees it.
#pragma once

#include <takt/component.hpp>

namespace takt::executor {

/// How a call of a module went.
struct Outcome {
  ErrorType type = ErrorType::none;
  const char* text = nullptr;  ///< why not; valid until the next call on this thread

  constexpr Outcome() = default;
  constexpr Outcome(ErrorType error, const char* why) : type(error), text(why) {}
  /// Null when it went well; else a failure.
  constexpr Outcome(const char* failure)  // NOLINT(google-explicit-constructor)
      : type(failure == nullptr ? ErrorType::none : ErrorType::failure), text(failure) {}
  [[nodiscard]] constexpr bool ok() const noexcept { return type == ErrorType::none; }
};

/// Implemented by the host for what it has loaded, and by tests and simulation. Real-time.
class Body {
 public:
  virtual ~Body() = default;
  /// One run().
  virtual Outcome run(const Cycle& cycle) noexcept = 0;
  /// Whether a sporadic module is to run: false in `*ready` when not. Only `number`, `time` and `start` of
  /// the cycle say something.
  virtual Outcome condition(const Cycle& cycle, bool* ready) noexcept = 0;
  /// Whether an event port has a sample that was not read yet and is valid by now. Asked of modules that are
  /// dispatched at once.
  [[nodiscard]] virtual bool has_news(Instant /*now*/) const noexcept { return false; }
  /// Takes the place of `before`, a body of the same module and kind, between two rows, and goes on where
  /// that has come to. False: not now, and nothing has changed.
  virtual bool take_over(Body& /*before*/) noexcept { return true; }
};

}  // namespace takt::executor
