// Reports rejected participants and packets, at a limited rate.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <mutex>
#include <set>
#include <string>

namespace takt::wire {

/// Reports each text only once, and at most ten texts per minute, because anyone on the network can cause any
/// number of reports. Any thread may call tell().
class Notices {
 public:
  using Clock = std::chrono::steady_clock;
  explicit Notices(std::function<void(const std::string&)> told) : told_(std::move(told)) {}
  void tell(const std::string& text, Clock::time_point now = Clock::now());
  /// Reports a text without a limit. For what only participants of the cell can cause.
  void tell_unlimited(const std::string& text) const {
    if (told_) told_(text);
  }

 private:
  std::function<void(const std::string&)> told_;
  std::mutex mutex_;
  std::set<std::string> known_;
  Clock::time_point since_{};
  int in_this_minute_ = 0;
  std::uint64_t held_back_ = 0;
};

}  // namespace takt::wire
