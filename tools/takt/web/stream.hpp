// The streams of server-sent events from `takt web` to browsers.
//
// Each browser has its own queue, because a browser may be slow and a tablet may sleep. If a queue is full,
// its stream ends. The browser then reconnects by itself and gets the complete state again.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace takt::tool::web {

/// An event in the format of server-sent events. `data` must be one line.
std::string event_text(const std::string& name, const std::string& data);

/// The queue of events for one browser. Any thread may call its functions.
class Stream {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20;  ///< limit of the queued bytes

  explicit Stream(std::string id) : id_(std::move(id)) {}

  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  /// Queues an event. Ends the stream if the queue would exceed kMostBytes.
  void send(const std::string& text);
  /// Waits for events, at most `limit`, and returns all queued events. The text is empty if no event arrived.
  /// None if the stream has ended.
  std::optional<std::string> next(std::chrono::milliseconds limit);
  void end();
  [[nodiscard]] bool ended() const;

 private:
  const std::string id_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::string waiting_;
  bool ended_ = false;
};

/// The streams of all browsers. Any thread may call its functions.
class Streams {
 public:
  static constexpr std::size_t kMost = 64;

  /// Opens a new stream. Null if kMost streams are open, or after end().
  std::shared_ptr<Stream> open();
  void close(const std::shared_ptr<Stream>& stream);
  void send(const std::string& text);
  [[nodiscard]] std::shared_ptr<Stream> find(const std::string& id) const;
  [[nodiscard]] std::size_t count() const;
  void end();

 private:
  mutable std::mutex mutex_;
  std::set<std::shared_ptr<Stream>> all_;
  bool ended_ = false;
};

/// As many random bytes as `bytes` says, written in hexadecimal digits.
std::string random_word(std::size_t bytes);

}  // namespace takt::tool::web
