// A TCP connection that a server has accepted.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <takt/core/time.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// A TCP connection to a client, which may be slow or hostile. No function waits longer than its deadline.
class TcpConnection {
 public:
  explicit TcpConnection(Fd fd) noexcept : fd_(std::move(fd)) {}

  enum class Received { bytes, nothing, end };
  /// Appends bytes that have arrived to `text`, at most `most` bytes and at most 64 KiB. Never waits. Returns
  /// `end` if the client sends no more bytes, or if the connection is broken.
  Received receive(std::string& text, std::size_t most);
  /// Sends the bytes, and waits until the system has taken all of them. Returns false if the connection is
  /// broken or the client has not read enough by the deadline. With a deadline in the past, does not wait.
  bool send(std::string_view bytes, Instant deadline);
  /// Tells the client that no more bytes follow. The client may continue to send.
  void end_sending() noexcept;
  /// Ends the connection in both directions. A call of send() on another thread returns false.
  void shut_down() noexcept;
  /// Returns the IP address of the client; empty if the connection is broken.
  [[nodiscard]] std::string peer() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

}  // namespace takt::os
