// A lock that prevents the handling of packets while a reader is created or deleted. In Fast DDS 2.9.1 the
// thread that handles a liveliness message iterates over the list of all readers without a lock (Fast DDS
// issue 2110). If the list is reallocated at that moment, the thread reads freed memory. For the source files
// of this room only.
#pragma once

#include <chrono>
#include <mutex>
#include <shared_mutex>
#include <utility>

namespace takt::dds {

class ReceiveLock {
 public:
  /// Runs `call`, which handles a packet, unless a Pause holds; waits for the end of the Pause. The receive
  /// threads call this for each packet.
  template <class Call>
  void handle(Call&& call) {
    const std::shared_lock lock{mutex_};
    handles_ = true;
    std::forward<Call>(call)();
    handles_ = false;
  }

  /// While this object exists and holds() is true, no packet is handled. The constructor waits until the
  /// handling of current packets has ended. It waits at most kLongest, because a handler may wait for the
  /// calling thread. If the calling thread itself is handling a packet, the constructor does not wait, and
  /// holds() is false.
  class Pause {
   public:
    explicit Pause(ReceiveLock& of) : lock_(of.mutex_, std::defer_lock) {
      if (!handles_) static_cast<void>(lock_.try_lock_for(kLongest));
    }
    [[nodiscard]] bool holds() const noexcept { return lock_.owns_lock(); }

   private:
    std::unique_lock<std::shared_timed_mutex> lock_;
  };
  static constexpr std::chrono::milliseconds kLongest{200};

 private:
  std::shared_timed_mutex mutex_;
  static inline thread_local bool handles_ = false;
};

}  // namespace takt::dds
