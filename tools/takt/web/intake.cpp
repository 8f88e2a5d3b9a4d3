#include "web/intake.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include <takt/os/clock.hpp>
#include <takt/os/signals.hpp>

namespace takt::tool::web {

namespace {

using Received = os::TcpConnection::Received;

// After the response, the intake discards what the client still sends, for at most this time. If it closed
// the connection at once, the system would discard the response too.
constexpr std::chrono::seconds kLinger{2};
constexpr std::size_t kAtOnce = std::size_t{64} << 10;
constexpr std::chrono::milliseconds kLongestWait{1000};

std::string response_of(const Answer& answer) {
  return fmt::format(
      "HTTP/1.1 {} \r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{}",
      answer.status, answer.body.size(), answer.body);
}

}  // namespace

Intake::Intake(os::Notice notice, Serve serve) : notice_(std::move(notice)), serve_(std::move(serve)) {
  thread_ = std::thread{[this] { run(); }};
}

Result<std::unique_ptr<Intake>> Intake::create(Serve serve) {
  auto notice = os::Notice::create();
  if (!notice) return notice.problems();
  return std::unique_ptr<Intake>{new Intake{std::move(*notice), std::move(serve)}};
}

void Intake::stop() {
  {
    const std::lock_guard lock{mutex_};
    ended_ = true;
    for (const auto& client : served_) client->connection.shut_down();
  }
  notice_.give();
  if (thread_.joinable()) thread_.join();
}

void Intake::add(os::Fd connection) {
  {
    const std::lock_guard lock{mutex_};
    arrived_.push_back(std::make_shared<Client>(Client{.connection = os::TcpConnection{std::move(connection)},
                                                       .deadline = os::now() + IncomingRequest::kLimit}));
  }
  notice_.give();
}

void Intake::finish(const std::shared_ptr<Client>& client) {
  end(*client);
  {
    const std::lock_guard lock{mutex_};
    served_.erase(client);
    arrived_.push_back(client);
  }
  notice_.give();
}

void Intake::end(Client& client) {
  client.connection.end_sending();
  client.answered = true;
  client.deadline = os::now() + kLinger;
}

void Intake::run() {
  while (take_arrived()) {
    wait();
    notice_.take();
    std::erase_if(clients_, [this](const auto& client) { return !step(client); });
  }
}

// Takes the clients from other threads. If there are too many connections, closes those with the earliest
// deadlines. Returns false after stop().
bool Intake::take_arrived() {
  const std::lock_guard lock{mutex_};
  clients_.insert(clients_.end(), arrived_.begin(), arrived_.end());
  arrived_.clear();
  while (clients_.size() + served_.size() > kMost && !clients_.empty()) {
    clients_.erase(std::min_element(clients_.begin(), clients_.end(),
                                    [](const auto& a, const auto& b) { return a->deadline < b->deadline; }));
  }
  return !ended_;
}

void Intake::wait() const {
  std::vector<const os::Fd*> fds{&notice_.fd()};
  Instant until = os::now() + kLongestWait;
  for (const auto& client : clients_) {
    fds.push_back(&client->connection.fd());
    until = std::min(until, client->deadline);
  }
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - os::now());
  os::wait_readable(fds, static_cast<int>(std::max<std::int64_t>(left.count(), 0)));
}

// Receives from a client. Returns false if the intake no longer reads from it.
bool Intake::step(const std::shared_ptr<Client>& client) {
  IncomingRequest& request = client->request;
  bytes_.clear();
  const Received received = client->connection.receive(bytes_, kAtOnce);
  if (received == Received::end) return false;
  bool rejected = false;
  if (received == Received::bytes && !client->answered) {
    const IncomingRequest::State state = request.take(bytes_);
    if (state == IncomingRequest::State::complete) {
      {
        const std::lock_guard lock{mutex_};
        served_.insert(client);
      }
      serve_(client);
      return false;
    }
    rejected = state == IncomingRequest::State::rejected;
  }
  if (!rejected && os::now() >= client->deadline) {
    if (client->answered || !request.has_begun()) return false;
    request.expire();
    rejected = true;
  }
  if (rejected) {
    client->connection.send(response_of(request.rejection()), {});
    end(*client);
  }
  return true;
}

}  // namespace takt::tool::web
