// A course of execution with a stack of its own, that runs until it hands over to another one. Many of them
// are one thread: nothing happens at the same time, and who goes on is the program's decision.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace takt::os {

/// All fibers that hand over to each other belong to one thread. Sanitizers are told of each change of stack.
class Fiber {
 public:
  /// The course that the calling thread is in already, for others to come back to.
  Fiber();
  /// Runs `body` when it is handed over to for the first time. `body` never returns, and lets no exception
  /// out: it ends by never being handed over to again. The stack has at least this many bytes and a page
  /// after its end that nobody may touch. Ends the process when there is no memory for it.
  Fiber(std::size_t stack_bytes, std::function<void()> body);
  /// Not of the one that runs. What its functions had on the stack is not destroyed.
  ~Fiber();
  Fiber(const Fiber&) = delete;
  Fiber& operator=(const Fiber&) = delete;

  /// Called by this one while it runs: the other goes on where it was; this one does when somebody hands over
  /// to it. Not while an exception is being handled.
  void hand_over_to(Fiber& other);

 private:
  struct Course;
  static void enter(unsigned low, unsigned high);
  std::unique_ptr<Course> course_;
};

}  // namespace takt::os
