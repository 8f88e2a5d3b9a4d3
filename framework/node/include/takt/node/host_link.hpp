// The node's end of the connection to a host: its process, the requests to it, and its answers.
#pragma once

#include <optional>
#include <string>

#include <takt/channel/channel.hpp>
#include <takt/core/result.hpp>
#include <takt/host/protocol.hpp>
#include <takt/node/output.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>

namespace takt::node {

class HostLink {
 public:
  /// Starts takt-host from os::private_directory() and sends it its setup. `environment` is added to the
  /// node's own.
  Result<void> start(const channel::Channel& channel, const host::Setup& setup,
                     const std::vector<const os::Fd*>& inherit,
                     const std::vector<std::pair<std::string, std::string>>& environment);

  /// Sends a request; false if the host is gone. Never waits; flush() must be called regularly.
  bool ask(const host::Request& request) { return socket_.send(host::encode(request)); }
  void flush() { socket_.flush(); }
  /// The next answer that has arrived; does not wait.
  std::optional<host::Answer> answer();
  /// How the host ended; returned only once.
  std::optional<os::ProcessEnd> ended() { return child_.poll(); }

  void kill() const noexcept;
  [[nodiscard]] bool running() const noexcept { return child_.running(); }
  [[nodiscard]] int pid() const noexcept { return pid_; }
  [[nodiscard]] const os::Fd& fd() const noexcept { return socket_.fd(); }
  [[nodiscard]] Output& output() noexcept { return output_; }

 private:
  os::MessageSocket socket_;
  os::Child child_;
  Output output_;
  int pid_ = 0;
};

}  // namespace takt::node
