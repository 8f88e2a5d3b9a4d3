#include <takt/os/message_socket.hpp>

#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "error.hpp"

namespace takt::os {

namespace {
using Length = std::uint32_t;  // each message begins with its length
constexpr Length kMaxLength = 256U * 1024 * 1024;
constexpr Length kWithFile = 1U << 31;  // set in the length if a descriptor comes with the message

/// Room for one descriptor beside the bytes of a message.
struct Control {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> bytes{};
};
}  // namespace

Result<std::pair<MessageSocket, MessageSocket>> MessageSocket::pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return errno_problem("socketpair", "free file descriptors");
  }
  return std::pair{MessageSocket{Fd{ends[0]}}, MessageSocket{Fd{ends[1]}}};
}

bool MessageSocket::send(const std::string& message, std::shared_ptr<const Fd> file) {
  const auto length = static_cast<Length>(message.size()) | (file != nullptr ? kWithFile : 0);
  if (file != nullptr) files_to_send_.push_back({.at = to_send_.size(), .fd = std::move(file)});
  to_send_.append(reinterpret_cast<const char*>(&length), sizeof length);
  to_send_ += message;
  return flush();
}

bool MessageSocket::flush() {
  std::size_t sent = 0;
  bool gone = false;
  while (sent < to_send_.size()) {
    const bool with_file = !files_to_send_.empty() && files_to_send_.front().at == sent;
    const std::size_t next = with_file ? 1 : 0;
    const std::size_t end = files_to_send_.size() > next ? files_to_send_[next].at : to_send_.size();
    iovec bytes{.iov_base = to_send_.data() + sent, .iov_len = end - sent};
    msghdr message{};
    message.msg_iov = &bytes;
    message.msg_iovlen = 1;
    Control control;
    if (with_file) {
      message.msg_control = control.bytes.data();
      message.msg_controllen = control.bytes.size();
      cmsghdr* const header = CMSG_FIRSTHDR(&message);
      header->cmsg_level = SOL_SOCKET;
      header->cmsg_type = SCM_RIGHTS;
      header->cmsg_len = CMSG_LEN(sizeof(int));
      const int fd = files_to_send_.front().fd->get();
      std::memcpy(CMSG_DATA(header), &fd, sizeof fd);
    }
    const ssize_t n = ::sendmsg(fd_.get(), &message, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno == EINTR) continue;
    gone = n < 0 && errno != EAGAIN;
    if (n <= 0) break;
    if (with_file) files_to_send_.pop_front();
    sent += static_cast<std::size_t>(n);
  }
  to_send_.erase(0, sent);
  for (File& file : files_to_send_) file.at -= sent;
  return !gone;
}

bool MessageSocket::send_wait(const std::string& message) {
  if (!send(message)) return false;
  while (!to_send_.empty()) {
    pollfd wanted{.fd = fd_.get(), .events = POLLOUT, .revents = 0};
    ::poll(&wanted, 1, -1);
    if (!flush()) return false;
  }
  return true;
}

std::optional<std::string> MessageSocket::next_message() {
  Length length = 0;
  if (received_.size() < sizeof length) return std::nullopt;
  std::memcpy(&length, received_.data(), sizeof length);
  const bool with_file = (length & kWithFile) != 0;
  length &= ~kWithFile;
  if (length > kMaxLength) {
    closed_ = true;
    return std::nullopt;
  }
  if (received_.size() < sizeof length + length) return std::nullopt;
  std::string message = received_.substr(sizeof length, length);
  received_.erase(0, sizeof length + length);
  file_.close();
  if (with_file && !received_files_.empty()) {
    file_ = std::move(received_files_.front());
    received_files_.pop_front();
  }
  return message;
}

long MessageSocket::receive_some(char* buffer, std::size_t size) {
  if (!accepts_files_) return ::recv(fd_.get(), buffer, size, MSG_DONTWAIT);
  iovec bytes{.iov_base = buffer, .iov_len = size};
  Control control;
  msghdr message{};
  message.msg_iov = &bytes;
  message.msg_iovlen = 1;
  message.msg_control = control.bytes.data();
  message.msg_controllen = control.bytes.size();
  const ssize_t n = ::recvmsg(fd_.get(), &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  const cmsghdr* const header = n > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (header != nullptr && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS) {
    int fd = -1;
    std::memcpy(&fd, CMSG_DATA(header), sizeof fd);
    received_files_.emplace_back(fd);
  }
  return n;
}

std::optional<std::string> MessageSocket::receive() {
  std::array<char, 65536> buffer{};
  while (true) {
    if (auto message = next_message()) return message;
    if (closed_) return std::nullopt;
    const long n = receive_some(buffer.data(), buffer.size());
    if (n > 0) {
      received_.append(buffer.data(), static_cast<std::size_t>(n));
      continue;
    }
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN) return std::nullopt;
    closed_ = true;
  }
}

std::optional<std::string> MessageSocket::receive_wait() {
  while (true) {
    if (auto message = receive()) return message;
    if (closed_) return std::nullopt;
    pollfd wanted{.fd = fd_.get(), .events = POLLIN, .revents = 0};
    ::poll(&wanted, 1, -1);
  }
}

}  // namespace takt::os
