// Runs the program peer.cpp in another process. The tests communicate with it over DDS and over pipes.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "fast_dds.hpp"

#include <long_enough.hpp>

namespace takt::dds_test {

class Peer {
 public:
  /// Starts the process with the command in `arguments`, and adds `variables` to its environment.
  explicit Peer(const std::vector<std::string>& arguments,
                const std::map<std::string, std::string>& variables = {});
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  /// Kills the process if it has not ended.
  ~Peer();

  void write(const std::string& line) const;
  /// Returns the next line that the process prints. Returns no line if the process ends or prints nothing
  /// within `limit`.
  std::optional<std::string> line(std::chrono::milliseconds limit = long_enough());
  /// Returns true if the process prints the line `wanted` within `limit`. Skips other lines.
  bool prints(const std::string& wanted, std::chrono::milliseconds limit = long_enough());
  void signal(int number) const;
  /// Returns the exit status of the process, or -1 if the process does not exit by itself within `limit`.
  int wait(std::chrono::milliseconds limit = long_enough());
  [[nodiscard]] int pid() const { return pid_; }

 private:
  int pid_ = 0;
  int in_ = -1;
  int out_ = -1;
  std::string read_;
};

/// Returns a sample in its wire format, as hexadecimal digits, as `dds_peer forge` takes it.
template <class Generated>
std::string in_hex(typename Generated::type& sample) {
  Generated type;
  dds::rtps::SerializedPayload_t payload{dds::max_size_of(type)};
  dds::encode_sample(type, &sample, payload);
  std::string text;
  for (std::uint32_t i = 0; i < payload.length; ++i) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02x", payload.data[i]);
    text += digits.data();
  }
  return text;
}

/// Checks the condition every millisecond until it holds. Returns false if it does not hold within `limit`.
template <class Condition>
bool soon(Condition condition, std::chrono::milliseconds limit = long_enough());

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
