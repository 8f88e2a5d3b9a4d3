// How many participants may be there who have not proved who they are, where DDS Security is on. Anybody can
// announce some by the thousand, under numbers that he makes up, and each costs all nodes time and memory
// until it is taken for gone. Not for other rooms.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>

#include <takt/dds/rtps.hpp>

namespace takt::dds {

class UnauthenticatedParticipants {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kOfOneAddress = 128;
  static constexpr std::size_t kInAll = 1024;
  static constexpr std::uint32_t kLongestLease = 100;  // s; the specification's own
  static constexpr std::uint32_t kShortestStay = 20;   // s; what a place is taken for at least

  /// Whether the sender of this announcement, at this IPv4 address, may be known. Any thread.
  [[nodiscard]] bool admit(const Announcement& announcement, std::uint32_t address,
                           Clock::time_point now = Clock::now());
  /// It proved who it is. Any thread.
  void proved(const ParticipantNumber& number);
  /// It left. One that had not proved who it is keeps its place until it would be gone: who comes and goes at
  /// once is no less work. Any thread.
  void left(const ParticipantNumber& number);

 private:
  struct Known {
    std::uint32_t address = 0;
    bool proved = false;
    Clock::time_point until;  // unless it announces itself again
  };
  void count_out(Known& one);
  void take_leave(Clock::time_point now);

  std::mutex mutex_;
  std::map<ParticipantNumber, Known> known_;
  std::map<std::uint32_t, std::size_t> unproved_;  // of each address
  std::size_t unproved_in_all_ = 0;
  Clock::time_point looked_;
};

}  // namespace takt::dds
