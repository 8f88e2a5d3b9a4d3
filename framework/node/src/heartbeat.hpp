// What a node says of itself, ten times a second and at each change.
//
// Observers take a device for lost when they have not heard of it for 300 ms, so nothing that the node does
// may delay this: it has a thread of its own. But a node whose main loop hangs must not look well because of
// that: the loop gives a sign each time around, and when none came for two seconds the heartbeat says so.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>

#include <takt/wire/takt.h>
#include <takt/core/time.hpp>

namespace takt::node {

/// Where it goes: a dds::Writer, and in a test what reads along. One thread.
class DeviceLine {
 public:
  virtual ~DeviceLine() = default;
  virtual void write(const DeviceStatus& status) = 0;
  virtual void dispose(const DeviceStatus& key) = 0;

 protected:
  DeviceLine() = default;
  DeviceLine(const DeviceLine&) = default;
  DeviceLine& operator=(const DeviceLine&) = default;
};

class Heartbeat {
 public:
  static constexpr std::chrono::milliseconds kEvery{100};
  static constexpr Nanoseconds kHangs = std::chrono::seconds{2};

  /// Any thread: said at once, and from now on.
  void set(const DeviceStatus& status);
  /// By the main loop, each time around.
  void sign(Instant now);

  /// Ends a wait of serve().
  void wake();

  /// On its own thread: waits for a change or the next beat, then says what is so.
  void serve(DeviceLine& line);
  /// The same without waiting.
  void beat(DeviceLine& line, Instant now, std::int64_t wall_ns);
  /// Takes back the last key.
  void leave(DeviceLine& line);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<DeviceStatus> status_;
  bool news_ = false;
  Instant signed_at_{};
  std::uint64_t sequence_ = 0;
  std::optional<DeviceStatus> said_;  // last, of the serving thread
};

}  // namespace takt::node
