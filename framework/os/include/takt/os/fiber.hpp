// Fibers: functions with their own stacks that take turns on one thread. Each runs until it hands over to
// another one, so nothing runs in parallel and the program decides which fiber runs next.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace takt::os {

/// All fibers that hand over to each other must belong to one thread. Sanitizers are notified of each stack
/// switch.
class Fiber {
 public:
  /// A fiber for the code that the calling thread runs now, so that other fibers can hand over to it.
  Fiber();
  /// Runs `body` at the first handover. `body` must not return and must not throw; a fiber ends when nothing
  /// hands over to it again. The stack has at least this many bytes, and a guard page at its end. Ends the
  /// process if there is no memory for the stack.
  Fiber(std::size_t stack_bytes, std::function<void()> body);
  /// The fiber must not be running. Objects on its stack are not destroyed.
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// Only this fiber may call it, while it runs and handles no exception. The other fiber continues where it
  /// stopped. This fiber continues when another fiber hands over to it.
  void hand_over_to(Fiber& other);

 private:
  struct Course;
  static void enter(unsigned low, unsigned high);
  std::unique_ptr<Course> course_;
};

}  // namespace takt::os
