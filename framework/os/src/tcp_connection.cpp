#include <takt/os/tcp_connection.hpp>

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>

#include <takt/os/clock.hpp>

namespace takt::os {

TcpConnection::Received TcpConnection::receive(std::string& text, std::size_t most) {
  std::array<char, std::size_t{64} << 10> bytes;  // NOLINT: not initialised, because that takes time
  ssize_t n = 0;
  do {
    n = ::recv(fd_.get(), bytes.data(), std::min(most, bytes.size()), MSG_DONTWAIT);
  } while (n < 0 && errno == EINTR);
  if (n > 0) {
    text.append(bytes.data(), static_cast<std::size_t>(n));
    return Received::bytes;
  }
  return n < 0 && errno == EAGAIN ? Received::nothing : Received::end;
}

bool TcpConnection::send(std::string_view bytes, Instant deadline) {
  while (!bytes.empty()) {
    const ssize_t n = ::send(fd_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (n >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(n));
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return false;
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - now());
    if (left.count() <= 0) return false;
    pollfd wanted{.fd = fd_.get(), .events = POLLOUT, .revents = 0};
    ::poll(&wanted, 1, static_cast<int>(left.count()));
  }
  return true;
}

void TcpConnection::end_sending() noexcept { ::shutdown(fd_.get(), SHUT_WR); }

void TcpConnection::shut_down() noexcept { ::shutdown(fd_.get(), SHUT_RDWR); }

std::string TcpConnection::peer() const {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  std::array<char, NI_MAXHOST> host{};
  auto* const any = reinterpret_cast<sockaddr*>(&address);  // NOLINT: the interface of sockets
  if (::getpeername(fd_.get(), any, &size) != 0 ||
      ::getnameinfo(any, size, host.data(), host.size(), nullptr, 0, NI_NUMERICHOST) != 0)
    return {};
  return host.data();
}

}  // namespace takt::os
