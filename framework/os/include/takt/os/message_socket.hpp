// A connection between a process and its parent process. It delivers whole messages in order, and detects
// when the other end has been closed.
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

  /// Creates two ends that are connected to each other.
  static Result<std::pair<MessageSocket, MessageSocket>> pair();

  /// Sends as many bytes of the message as the other end accepts now, and keeps the rest for flush(). Never
  /// waits. Returns false if the other end is closed.
  bool send(const std::string& message);
  /// Continues to send the bytes that send() kept. Returns false if the other end is closed.
  bool flush();
  /// Sends the message, and waits until the other end has accepted all bytes. Returns false if the other end
  /// is closed.
  bool send_wait(const std::string& message);
  /// Returns the next message if it has arrived completely, otherwise none. Does not wait. If the other end
  /// is closed, closed() returns true after this call.
  std::optional<std::string> receive();
  /// Waits for the next message. Returns none if the other end is closed.
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
