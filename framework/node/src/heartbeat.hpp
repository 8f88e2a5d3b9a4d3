// Publishes the device's status ten times a second and at each change.
//
// Observers regard a device as lost when they have received nothing from it for 300 ms. So the heartbeat has
// its own thread, which nothing in the node may delay. But a node whose main loop hangs must not look
// healthy. So the main loop calls kick() in each iteration. If two seconds pass without a call, the heartbeat
// reports that the loop hangs.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include <takt/wire/takt.h>
#include <takt/core/time.hpp>

namespace takt::node {

/// The destination of status samples. This is a dds::Writer, or a fake in tests. Only one thread uses it.
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

  /// Sets the status, which is published at once and with each beat. Any thread may call this.
  void set(const DeviceStatus& status);
  /// The main loop calls this in each iteration to show that it does not hang.
  void kick(Instant now);

  /// Makes serve() return if it is waiting.
  void wake();

  /// Runs on the heartbeat thread: waits for a change or the next beat, then publishes the status.
  void serve(DeviceSink& sink);
  /// Publishes the status without waiting.
  void beat(DeviceSink& sink, Instant now, std::int64_t wall_ns);
  /// Withdraws the last published status, because the device leaves.
  void leave(DeviceSink& sink);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<DeviceStatus> status_;
  bool news_ = false;
  Instant kicked_at_{};
  std::uint64_t sequence_ = 0;
  std::optional<DeviceStatus> published_;  // the last published status; only the heartbeat thread uses it
};

}  // namespace takt::node
