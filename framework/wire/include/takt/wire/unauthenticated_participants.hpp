// Limits the number of participants that have not authenticated, in a cell with DDS Security. Anyone can
// announce thousands of participants with invented GUIDs. Each of them costs all nodes time and memory until
// its lease expires. Only the room dds uses this.
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
  static constexpr std::uint32_t kLongestLease = 100;  // in s; the default of the specification
  static constexpr std::uint32_t kShortestStay = 20;   // in s; the least time for which a slot is held

  /// Whether to admit the sender of this announcement from this IPv4 address. Any thread may call it.
  [[nodiscard]] bool admit(const Announcement& announcement, std::uint32_t address,
                           Clock::time_point now = Clock::now());
  /// Call it when the participant has authenticated, on any thread.
  void authenticated(const ParticipantNumber& number);
  /// Call it when the participant has left, on any thread. A participant that has not authenticated holds its
  /// slot until its lease would expire, because frequent joining and leaving costs as much as staying.
  void left(const ParticipantNumber& number);

 private:
  struct Known {
    std::uint32_t address = 0;
    bool authenticated = false;
    Clock::time_point until;  // the time of expiry, unless the participant announces itself again
  };
  void count_authenticated(Known& one);
  void remove_expired(Clock::time_point now);

  std::mutex mutex_;
  std::map<ParticipantNumber, Known> known_;
  std::map<std::uint32_t, std::size_t> unauthenticated_;  // number for each address
  std::size_t unauthenticated_total_ = 0;
  Clock::time_point looked_;
};

}  // namespace takt::wire
