// Publishes the device's status ten times a second and at each change.
//
// Observers regard a device as lost when they have received nothing from it for 300 ms. So the heartbeat has
// its own thread, which nothing in the node may delay. But a node whose main loop hangs must not look
// healthy. So the main loop calls kick() in each iteration. If two seconds pass without a call of kick(), the
// heartbeat reports that the main loop hangs.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>

#include <takt/wire/takt.h>
#include <takt/core/time.hpp>

namespace takt::node {

/// The destination of status samples: a dds::Writer, or a fake in tests. Only one thread uses the sink.
class DeviceSink {
 public:
  virtual ~DeviceSink() = default;
  virtual void write(const DeviceStatus& status) = 0;
  virtual void dispose(const DeviceStatus& key) = 0;

 protected:
  DeviceSink() = default;
  DeviceSink(const DeviceSink&) = default;
  DeviceSink& operator=(const DeviceSink&) = default;
};

class Heartbeat {
 public:
  static constexpr std::chrono::milliseconds kEvery{100};
  static constexpr Nanoseconds kHangs = std::chrono::seconds{2};
  /// The number of nodes that one beat answers.
  static constexpr std::size_t kAnswered = 8;
  /// The number of nodes that may wait for an answer. The statuses of further nodes are not answered.
  static constexpr std::size_t kMostHeard = 1024;

  /// Sets the status. serve() publishes it at once, and then with each beat. Any thread may call set().
  void set(const DeviceStatus& status);
  /// The main loop calls this in each iteration to show that it does not hang.
  void kick(Instant now);

  /// Notes that the status with this `monotonic_ns` has arrived from another node. A beat answers it, so that
  /// the other node can compare its clock with the clock of this machine. Any thread may call it.
  void heard(const std::string& node, std::int64_t monotonic_ns, Instant arrived);

  /// Makes serve() return if it is waiting.
  void wake();

  /// Waits for a new status or the next beat, then publishes the status. The heartbeat thread calls serve()
  /// repeatedly.
  void serve(DeviceSink& sink);
  /// Publishes the status without waiting.
  void beat(DeviceSink& sink, Instant now, std::int64_t wall_ns);
  /// Withdraws the status that was published last. Called when the node shuts down.
  void leave(DeviceSink& sink);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<DeviceStatus> status_;
  bool news_ = false;
  struct Heard {
    std::string node;
    std::int64_t monotonic_ns = 0;
    Instant arrived{};
  };
  std::deque<Heard> unanswered_;  // the newest status of each node; the node that waits longest is the first
  Instant kicked_at_{};
  std::uint64_t sequence_ = 0;
  // The status that was published last. Only the heartbeat thread uses this member.
  std::optional<DeviceStatus> published_;
};

}  // namespace takt::node
