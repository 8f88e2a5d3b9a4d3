// Messages between a program and the one that started it: whole texts, in order, and the news of the other's
// end.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class MessageSocket {
 public:
  MessageSocket() = default;
  explicit MessageSocket(Fd fd) : fd_(std::move(fd)) {}

  /// Two connected ends.
  static Result<std::pair<MessageSocket, MessageSocket>> pair();

  /// Sends what the other end takes now and keeps the rest for flush(); never waits. False when the other end
  /// is gone.
  bool send(const std::string& message);
  /// Sends more of what send() kept. False when the other end is gone.
  bool flush();
  /// The same as send(), but waits until the other end has taken everything.
  bool send_wait(const std::string& message);
  /// The next whole message if it has arrived; does not wait. Sets closed() when the other end is gone.
  std::optional<std::string> receive();
  /// Waits for the next message; none when the other end is gone.
  std::optional<std::string> receive_wait();

  [[nodiscard]] bool closed() const noexcept { return closed_; }
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }
  void close() noexcept { fd_.close(); }

 private:
  std::optional<std::string> next_message();

  Fd fd_;
  std::string received_;
  std::string to_send_;
  bool closed_ = false;
};

}  // namespace takt::os
