// Fibers: functions with their own stacks that take turns on one thread. A fiber runs until it hands over to
// another fiber. So fibers never run in parallel, and the program decides which of them runs next.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace takt::os {

/// A fiber. Fibers that hand over to each other must all belong to the same thread. Each switch of stacks is
/// announced to the sanitizers.
class Fiber {
 public:
  /// Creates a fiber for the code that the calling thread runs now, so that other fibers can hand over to
  /// this code.
  Fiber();
  /// Creates a fiber that runs `body` when another fiber first hands over to it. `body` must not return and
  /// must not throw; a fiber ends when no other fiber hands over to it again. The stack has at least
  /// `stack_bytes` bytes and a guard page at its end. Ends the process if there is no memory for the stack.
  Fiber(std::size_t stack_bytes, std::function<void()> body);
  /// The fiber must not be running. The destructors of objects on its stack are not called.
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// Stops this fiber and continues the other one where it stopped. This fiber continues when another fiber
  /// hands over to it. Only this fiber itself may call this, while it runs, and not while it handles an
  /// exception.
  void hand_over_to(Fiber& other);

 private:
  struct Course;
  static void enter(unsigned low, unsigned high);
  std::unique_ptr<Course> course_;
};

}  // namespace takt::os
