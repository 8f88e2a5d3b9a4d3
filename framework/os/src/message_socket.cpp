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
}  // namespace

Result<std::pair<MessageSocket, MessageSocket>> MessageSocket::pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    return errno_problem("socketpair", "free file descriptors");
  }
  return std::pair{MessageSocket{Fd{ends[0]}}, MessageSocket{Fd{ends[1]}}};
}

bool MessageSocket::send(const std::string& message) {
  const auto length = static_cast<Length>(message.size());
  to_send_.append(reinterpret_cast<const char*>(&length), sizeof length);
  to_send_ += message;
  return flush();
}

bool MessageSocket::flush() {
  std::size_t sent = 0;
  bool gone = false;
  while (sent < to_send_.size()) {
    const ssize_t n =
        ::send(fd_.get(), to_send_.data() + sent, to_send_.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (n < 0 && errno == EINTR) continue;
    gone = n < 0 && errno != EAGAIN;
    if (n <= 0) break;
    sent += static_cast<std::size_t>(n);
  }
  to_send_.erase(0, sent);
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
  if (length > kMaxLength) {
    closed_ = true;
    return std::nullopt;
  }
  if (received_.size() < sizeof length + length) return std::nullopt;
  std::string message = received_.substr(sizeof length, length);
  received_.erase(0, sizeof length + length);
  return message;
}

std::optional<std::string> MessageSocket::receive() {
  std::array<char, 65536> buffer{};
  while (true) {
    if (auto message = next_message()) return message;
    if (closed_) return std::nullopt;
    const ssize_t n = ::recv(fd_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
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
