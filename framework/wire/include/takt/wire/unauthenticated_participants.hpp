// Limits the number of participants that have not authenticated, in a cell with DDS Security. Anyone can
// announce thousands of participants with invented GUIDs. Each such participant costs all nodes time and
// memory until its lease expires.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <vector>

#include <takt/wire/rtps.hpp>

namespace takt::wire {

class UnauthenticatedParticipants {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kOfOneAddress = 128;
  static constexpr std::size_t kInAll = 1024;
  static constexpr std::uint32_t kLongestLease = 100;  // in s; the default lease in the RTPS specification
  static constexpr std::uint32_t kShortestStay = 20;   // in s; a slot is held for at least this time

  /// Returns true if the limits allow the participant that announces itself from this IPv4 address. Any
  /// thread may call admit().
  [[nodiscard]] bool admit(const Announcement& announcement, std::uint32_t address,
                           Clock::time_point now = Clock::now());
  /// Frees the slot of a participant that has authenticated. Any thread may call authenticated().
  void authenticated(const ParticipantNumber& number);
  /// Forgets a participant that has authenticated and has now left. An unauthenticated participant holds its
  /// slot until its lease would expire, because repeated joining and leaving costs as much as staying. Any
  /// thread may call left().
  void left(const ParticipantNumber& number);
  /// Removes the participants that have not announced themselves for so long that their slot has expired,
  /// also those that have authenticated, and returns them. Any thread may call remove_expired().
  std::vector<ParticipantNumber> remove_expired(Clock::time_point now = Clock::now());

 private:
  struct Known {
    std::uint32_t address = 0;
    bool authenticated = false;
    Clock::time_point until;  // when the slot expires; each further announcement of the participant postpones
                              // this
  };
  void count_authenticated(Known& one);

  std::mutex mutex_;
  std::map<ParticipantNumber, Known> known_;
  std::map<std::uint32_t, std::size_t> unauthenticated_;  // number of unauthenticated participants, by
                                                          // address
  std::size_t unauthenticated_total_ = 0;
};

}  // namespace takt::wire
