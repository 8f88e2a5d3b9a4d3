// The threads that a module starts itself. They run the module's code, so it must stay loaded while they run.
#pragma once

#include <memory>

namespace takt::host {

/// An object that belongs to one loaded instance of a module. Each thread that the instance has started holds
/// a reference to it until the thread ends.
using OwnThreads = std::shared_ptr<const char>;

/// Exists while the calling thread is in code of an instance. Makes no system call and does not allocate.
class InInstance {
 public:
  explicit InInstance(const OwnThreads& instance) noexcept : before_(current_) { current_ = &instance; }
  ~InInstance() { current_ = before_; }
  InInstance(const InInstance&) = delete;
  InInstance& operator=(const InInstance&) = delete;

  /// The instance in whose code the calling thread is; null if it is in none.
  static OwnThreads current() noexcept { return current_ == nullptr ? nullptr : *current_; }

 private:
  static inline thread_local const OwnThreads* current_ = nullptr;
  const OwnThreads* before_;
};

/// From now on, the timers of the instance no longer call it when they expire.
void stop_timers(const OwnThreads& instance);
/// Deletes all timers that the instance still has. Returns false if it had none.
bool delete_timers(const OwnThreads& instance);

}  // namespace takt::host
