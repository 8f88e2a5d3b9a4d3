// A connection between a process and its parent process. It delivers whole messages in order, and detects
// when the other end has been closed.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
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
  /// waits. Returns false if the other end is closed. If `file` is given, the other end gets a duplicate of
  /// this descriptor with the message.
  bool send(const std::string& message, std::shared_ptr<const Fd> file = nullptr);
  /// Continues to send the bytes that send() kept. Returns false if the other end is closed.
  bool flush();
  /// Sends the message, and waits until the other end has accepted all bytes. Returns false if the other end
  /// is closed.
  bool send_wait(const std::string& message);
  /// Returns the next message if it has arrived completely, otherwise none. Does not wait. If the other end
  /// is closed, closed() returns true after this call.
  std::optional<std::string> receive();
  /// From now on, receive() accepts the descriptors that come with messages. Otherwise the kernel closes
  /// them, so that the other end cannot use up the descriptors of this process.
  void accept_files() noexcept { accepts_files_ = true; }
  /// Returns the descriptor that came with the last received message; an empty one if there was none.
  Fd take_file() noexcept { return std::exchange(file_, {}); }
  /// Waits for the next message. Returns none if the other end is closed.
  std::optional<std::string> receive_wait();

  [[nodiscard]] bool closed() const noexcept { return closed_; }
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }
  void close() noexcept { fd_.close(); }

 private:
  std::optional<std::string> next_message();
  /// Receives at most `size` bytes without waiting. Returns as recv() does.
  long receive_some(char* buffer, std::size_t size);

  Fd fd_;
  std::string received_;
  bool accepts_files_ = false;
  std::deque<Fd> received_files_;  // of messages that have not been returned yet
  Fd file_;                        // the one that came with the last message
  std::string to_send_;
  struct File {
    std::size_t at;  // the place in to_send_ of the byte with which it is sent
    std::shared_ptr<const Fd> fd;
  };
  std::deque<File> files_to_send_;
  bool closed_ = false;
};

}  // namespace takt::os
