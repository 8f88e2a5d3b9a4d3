// A takt-host process, and the node's end of the socket to it.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/node/output.hpp>
#include <takt/node/symbols.hpp>
#include <takt/os/message_socket.hpp>
#include <takt/os/process.hpp>
#include <takt/os/signals.hpp>
#include <takt/supervision/parts.hpp>
#include <takt/supervision/platform.hpp>

namespace takt::node {

/// The additional file descriptors and variables that a child process inherits from the node for a check or a
/// recording.
struct Inheritance {
  std::vector<const os::Fd*> descriptors;
  std::vector<std::pair<std::string, std::string>> environment;
};

class HostProcess final : public supervision::Host {
 public:
  /// `inheritance` is called at each start of the host.
  HostProcess(const supervision::Parts& parts, std::size_t share, std::function<Inheritance()> inheritance)
      : parts_(parts), share_(share), inheritance_(std::move(inheritance)) {}

  Result<void> start() override;
  bool ask(const host::Request& request) override;
  std::optional<host::Answer> answer() override;
  std::optional<supervision::ProcessEnd> ended() override;
  void kill() override { child_.signal(os::kKill); }
  void end_by(std::int32_t thread) override { child_.signal_thread(thread, os::kHangSignal); }
  [[nodiscard]] bool running() const override { return child_.running(); }
  [[nodiscard]] int pid() const override { return pid_; }
  supervision::CrashCalls calls_of_crash(std::uint32_t module) override;

  /// Sends the requests that had to wait because the socket was full, and logs the output of the host.
  void step(const std::string& device);
  void wait_on(std::vector<const os::Fd*>& fds) const;

 private:
  /// The file of a component as it was when the component was deployed, swapped or reset.
  struct Component {
    std::string path;
    std::shared_ptr<const os::Fd> copy;
    bool is_signed = false;
  };
  static Result<Component> open(const std::string& path);
  /// Returns the component that the request loads, and keeps it for later.
  Result<Component> component_of(const host::Request& request);

  const supervision::Parts& parts_;
  const std::size_t share_;
  const std::function<Inheritance()> inheritance_;
  os::MessageSocket socket_;
  os::Child child_;
  Output output_;
  int pid_ = 0;
  std::map<std::uint32_t, Component> components_;  // by module; kept while the host restarts
  std::map<std::uint32_t, Component> swapped_;     // those of swaps that have not been answered yet
  std::deque<host::Answer> unloadable_;            // to requests whose component could not be opened
  std::optional<Symbols> symbols_;                 // created after the first crash
};

/// Describes how a child process ended. If a signal ended the process, the description names its core dump,
/// or states why there is none.
supervision::ProcessEnd end_of(int pid, const os::ProcessEnd& end);

}  // namespace takt::node
