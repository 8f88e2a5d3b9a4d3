// Runs a command of the program peer.cpp in another process.
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace takt::dds_test {

class Peer {
 public:
  /// Starts the process with these variables added to its environment, in `folder` if one is given.
  explicit Peer(const std::vector<std::string>& arguments,
                const std::map<std::string, std::string>& variables = {}, const std::string& folder = {});
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  /// Kills the process if it still runs.
  ~Peer();

  void say(const std::string& line) const;
  /// Returns the next line that the process prints. None if it has ended, or prints nothing in time.
  std::optional<std::string> line(std::chrono::milliseconds limit = std::chrono::seconds{20});
  /// Returns whether the process prints this line in time. Skips other lines.
  bool says(const std::string& wanted, std::chrono::milliseconds limit = std::chrono::seconds{20});
  void signal(int number) const;
  /// Returns the exit status of the process; -1 if it did not end by itself in time.
  int wait(std::chrono::milliseconds limit = std::chrono::seconds{20});
  [[nodiscard]] int pid() const { return pid_; }

 private:
  int pid_ = 0;
  int in_ = -1;
  int out_ = -1;
  std::string read_;
};

/// Waits until the condition holds, and checks it each millisecond. Returns false if it does not hold in
/// time.
template <class Condition>
bool soon(Condition condition, std::chrono::milliseconds limit = std::chrono::seconds{20});

}  // namespace takt::dds_test

#include <thread>

template <class Condition>
bool takt::dds_test::soon(Condition condition, std::chrono::milliseconds limit) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return true;
}
