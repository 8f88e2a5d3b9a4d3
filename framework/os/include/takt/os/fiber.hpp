// Fibers: functions with their own stacks that take turns on one thread. A fiber runs until it hands over to
// another fiber. So fibers never run in parallel, and the code decides which fiber runs next.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace takt::os {

/// A fiber. Fibers that hand over to each other must belong to the same thread. If a sanitizer is active,
/// each switch of stacks is reported to the sanitizer.
class Fiber {
 public:
  /// Makes the code that calls this constructor a fiber, so that other fibers can hand over to it.
  Fiber();
  /// Creates a fiber, which begins to run `body` when another fiber first hands over to it. `body` must not
  /// return and must not throw. To end the fiber, no longer hand over to it. The fiber's stack has at least
  /// `stack_bytes` bytes and a guard page at its end. Ends the process if there is no memory for the stack.
  Fiber(std::size_t stack_bytes, std::function<void()> body);
  /// Frees the stack, without calling the destructors of objects on it. The fiber must not be running.
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// Stops this fiber, and continues `other` at the point where `other` stopped. This fiber continues when
  /// another fiber hands over to it. Call this only from the code of this fiber, and not while this code
  /// handles an exception.
  void hand_over_to(Fiber& other);

 private:
  struct Course;
  static void enter(unsigned low, unsigned high);
  std::unique_ptr<Course> course_;
};

}  // namespace takt::os
