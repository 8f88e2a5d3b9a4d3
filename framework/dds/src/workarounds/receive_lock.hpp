// A lock that keeps packets from being handled while a reader is created or deleted. In Fast DDS 2.9.1 the
// thread that handles a liveliness message walks the list of all readers without a lock (its issue 2110). If
// the list grows meanwhile, its memory moves. Not for other rooms.
#pragma once

#include <chrono>
#include <mutex>
#include <shared_mutex>
#include <utility>

namespace takt::dds {

class ReceiveLock {
 public:
  /// For the receiving threads.
  template <class Call>
  void handle(Call&& call) {
    const std::shared_lock lock{mutex_};
    handles_ = true;
    std::forward<Call>(call)();
    handles_ = false;
  }

  /// No packet is handled while this object exists. Its constructor waits for packets in progress, but at
  /// most kLongest, because their handlers may wait for the caller. A thread that handles a packet does not
  /// wait.
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
