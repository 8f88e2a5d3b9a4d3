// Reads the requests of all clients on one thread, so that slow clients occupy no other thread.
//
// The HTTP library serves each connection on a thread of its own, and a client can hold this thread as long
// as it likes by sending one byte now and then. So the library gets only complete requests. A client that is
// slow, or that sends too much, costs a small buffer and a limited time.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/notice.hpp>
#include <takt/os/tcp_connection.hpp>

#include "web/incoming_request.hpp"

namespace takt::tool::web {

/// A connection and the request that arrives on it. Each connection carries one request.
struct Client {
  os::TcpConnection connection;
  Instant deadline{};  ///< until then, the request must be complete or, if answered, the connection closed
  IncomingRequest request{};
  bool answered = false;
};

class Intake {
 public:
  /// If more connections are open, the intake closes those whose requests have been incomplete longest.
  static constexpr std::size_t kMost = 256;

  /// `serve` is called for each complete request, on the intake's thread, so it must not wait. Call finish()
  /// when the request has been answered.
  using Serve = std::function<void(std::shared_ptr<Client>)>;
  static Result<std::unique_ptr<Intake>> create(Serve serve);
  /// Ends the connections whose requests are being answered, so that a thread that writes to one of them does
  /// not wait. Such a thread may still call finish() after stop().
  void stop();
  ~Intake() { stop(); }

  /// Reads the request of a new connection. Any thread may call this.
  void add(os::Fd connection);
  /// Closes the connection of a request that has been answered. Any thread may call this.
  void finish(const std::shared_ptr<Client>& client);

 private:
  Intake(os::Notice notice, Serve serve);
  void run();
  bool take_arrived();
  void wait() const;
  bool step(const std::shared_ptr<Client>& client);
  static void end(Client& client);

  const os::Notice notice_;
  const Serve serve_;
  std::vector<std::shared_ptr<Client>> clients_;  // only the intake's thread uses it
  std::string bytes_;                             // only the intake's thread uses it
  std::mutex mutex_;
  std::vector<std::shared_ptr<Client>> arrived_;  // from add() and finish() to the intake's thread
  std::set<std::shared_ptr<Client>> served_;      // their requests are being answered
  bool ended_ = false;
  std::thread thread_;
};

}  // namespace takt::tool::web
