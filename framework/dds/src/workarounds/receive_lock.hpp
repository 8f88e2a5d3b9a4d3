// A lock that prevents the handling of packets while a reader is created or deleted, or a participant is
// removed. In Fast DDS 2.9.1, the thread that handles a liveliness message iterates over the list of all readers
// without a lock (Fast DDS issue 2110). If the list is reallocated at that moment, the thread reads freed
// memory. participant_removal.hpp says why the removal of a participant needs the lock. Only the source files of
// this room include this header.
#pragma once

#include <chrono>
#include <mutex>
#include <shared_mutex>
#include <utility>

namespace takt::dds {

class ReceiveLock {
 public:
  /// Runs `call`, which handles a packet. If a Pause exists whose holds() is true, waits until this Pause has
  /// ended. The receive threads call handle() for each packet.
  template <class Call>
  void handle(Call&& call) {
    const std::shared_lock lock{mutex_};
    run(std::forward<Call>(call));
  }
  /// Like handle(), but no other packet is handled at the same time: waits until the packets that are being
  /// handled are finished, at most for kLongest.
  template <class Call>
  void handle_alone(Call&& call) {
    if (const std::unique_lock lock{mutex_, kLongest}) return run(std::forward<Call>(call));
    handle(std::forward<Call>(call));
  }

  /// While this object exists and holds() is true, no packet is handled. The constructor waits until the
  /// packets that are being handled are finished. It waits at most kLongest, because a handler may wait for
  /// the calling thread. If the calling thread itself is handling a packet, the constructor does not wait,
  /// and holds() is false.
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
  template <class Call>
  static void run(Call&& call) {
    handles_ = true;
    std::forward<Call>(call)();
    handles_ = false;
  }

  std::shared_timed_mutex mutex_;
  static inline thread_local bool handles_ = false;
};

}  // namespace takt::dds
