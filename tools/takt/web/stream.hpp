// The streams of server-sent events to the browsers.
//
// A browser may be slow, or a tablet may sleep. So each browser has its own queue. If this queue is full, the
// stream ends. The browser then reconnects by itself and gets the complete state again.
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

/// The queue of one browser. Any thread may call its functions.
class Stream {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20;  ///< that may wait to be sent

  explicit Stream(std::string id) : id_(std::move(id)) {}

  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  /// Queues an event. Ends the stream if the queue would exceed kMostBytes.
  void send(const std::string& text);
  /// Waits for events, at most `limit`, and returns all of them. Empty if none arrived; none if the stream
  /// has ended.
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

/// All streams. Any thread may call its functions.
class Streams {
 public:
  static constexpr std::size_t kMost = 64;

  /// A new stream. Null if there are kMost streams, or after end().
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

/// `bytes` random bytes from the system, as hexadecimal digits.
std::string random_word(std::size_t bytes);

}  // namespace takt::tool::web
