// Readers are made and ended between packets, never while one is handled. In Fast DDS 2.9.1 the thread that
// takes a sign of life goes through the list of all readers without a lock (its issue 2110), and one that
// grows meanwhile is gone under it. Not for other rooms.
#pragma once

#include <chrono>
#include <mutex>
#include <shared_mutex>
#include <utility>

namespace takt::dds {

class ReceiveLock {
 public:
  /// By the threads that receive.
  template <class Call>
  void handle(Call&& call) {
    const std::shared_lock lock{mutex_};
    handles_ = true;
    std::forward<Call>(call)();
    handles_ = false;
  }

  /// No packet is handled while this lives. One that is under way is waited for, but not for ever: what it
  /// calls may be waiting for the caller. And not by the thread that handles it.
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
