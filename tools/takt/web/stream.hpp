// The streams of server-sent events from `takt web` to browsers.
//
// Each browser has its own queue, because a browser may be slow and a tablet may sleep. If a queue is full,
// its stream ends. The browser then reconnects by itself and gets the complete state again.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace takt::tool::web {

/// An event in the format of server-sent events. `data` must be one line.
std::string event_text(const std::string& name, const std::string& data);

/// The queue of events for one browser. Any thread may call its functions.
class Stream {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20;  ///< limit of the queued bytes
  /// If the queues of all streams together have more than kMostOfAll bytes, each may have only kShare bytes.
  static constexpr std::size_t kMostOfAll = std::size_t{64} << 20;
  static constexpr std::size_t kShare = std::size_t{512} << 10;

  /// `all` counts the queued bytes of all streams, and must outlive this object.
  Stream(std::string id, std::atomic<std::size_t>& all) : id_(std::move(id)), all_(all) {}
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  /// Queues an event. Ends the stream if there would be too many queued bytes.
  void send(const std::string& text);
  /// Waits for events, at most `limit`, and returns all queued events as one text, which is empty if no event
  /// arrived. Returns none if the stream has ended. The events count as queued until the next call.
  std::optional<std::string> next(std::chrono::milliseconds limit);
  void end();
  [[nodiscard]] bool ended() const;

 private:
  void count(std::size_t bytes);
  void forget(std::size_t bytes);

  const std::string id_;
  std::atomic<std::size_t>& all_;
  mutable std::mutex mutex_;
  std::condition_variable arrived_;
  std::string waiting_;
  std::size_t taken_ = 0;   // bytes that next() returned last
  std::size_t queued_ = 0;  // taken_ and the bytes that wait
  bool ended_ = false;
};

/// The streams of all browsers. Any thread may call its functions.
class Streams {
 public:
  static constexpr std::size_t kMost = 128;

  /// Opens a new stream to the browser at `address`. Null after end(), or if the address has as many streams
  /// as there are free places. So one address gets at most half of the places, and cannot keep the others
  /// out. A stream that has ended occupies a thread, and its place, until it is closed.
  std::shared_ptr<Stream> open(const std::string& address);
  void close(const std::shared_ptr<Stream>& stream);
  void send(const std::string& text);
  [[nodiscard]] std::shared_ptr<Stream> find(const std::string& id) const;
  [[nodiscard]] std::size_t count() const;
  void end();

 private:
  std::atomic<std::size_t> bytes_{0};
  mutable std::mutex mutex_;
  std::map<std::shared_ptr<Stream>, std::string> all_;  // with the address of the browser
  bool ended_ = false;
};

/// Returns `bytes` random bytes as hexadecimal digits.
std::string random_word(std::size_t bytes);

}  // namespace takt::tool::web
