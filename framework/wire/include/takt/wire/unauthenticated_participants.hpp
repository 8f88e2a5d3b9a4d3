// With DDS Security: limits the number of participants that have not authenticated. Anyone can announce
// thousands of participants with invented GUIDs. Each costs all nodes time and memory until its lease
// expires. Not for other rooms.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>

#include <takt/wire/rtps.hpp>

namespace takt::wire {

class UnauthenticatedParticipants {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kOfOneAddress = 128;
  static constexpr std::size_t kInAll = 1024;
  static constexpr std::uint32_t kLongestLease = 100;  // s; the default of the specification
  static constexpr std::uint32_t kShortestStay = 20;   // s; the least time for which a slot is taken

  /// Whether to admit the sender of this announcement from this IPv4 address. Any thread.
  [[nodiscard]] bool admit(const Announcement& announcement, std::uint32_t address,
                           Clock::time_point now = Clock::now());
  /// The participant has authenticated. Any thread.
  void authenticated(const ParticipantNumber& number);
  /// The participant left. If it had not authenticated, it keeps its slot until its lease would expire,
  /// because churn costs as much as staying. Any thread.
  void left(const ParticipantNumber& number);

 private:
  struct Known {
    std::uint32_t address = 0;
    bool authenticated = false;
    Clock::time_point until;  // expiry, unless it announces itself again
  };
  void count_authenticated(Known& one);
  void remove_expired(Clock::time_point now);

  std::mutex mutex_;
  std::map<ParticipantNumber, Known> known_;
  std::map<std::uint32_t, std::size_t> unauthenticated_;  // of each address
  std::size_t unauthenticated_total_ = 0;
  Clock::time_point looked_;
};

}  // namespace takt::wire
