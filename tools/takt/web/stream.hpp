// What goes to the browsers that look on, as server-sent events.
//
// A browser may be slow, or asleep on a tablet. So each has a queue of its own, and one whose queue is full
// is let go: it comes back by itself and is told everything anew.
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

/// An event as it goes over the wire. `data` is one line.
std::string event_text(const std::string& name, const std::string& data);

/// Of one browser. Any thread.
class Stream {
 public:
  static constexpr std::size_t kMostBytes = std::size_t{8} << 20;  ///< that wait to be sent

  explicit Stream(std::string id) : id_(std::move(id)) {}

  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  /// Ends the stream where it would be too much.
  void send(const std::string& text);
  /// All that waits; empty when nothing came for so long. None: the stream has ended.
  std::optional<std::string> next(std::chrono::milliseconds limit);
  void end();
  [[nodiscard]] bool ended() const;

 private:
  const std::string id_;
  mutable std::mutex mutex_;
  std::condition_variable came_;
  std::string waiting_;
  bool ended_ = false;
};

/// All of them. Any thread.
class Streams {
 public:
  static constexpr std::size_t kMost = 64;

  /// None where there are so many already, or after end().
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

/// So many random bytes of the system, as hexadecimal digits.
std::string random_word(std::size_t bytes);

}  // namespace takt::tool::web
