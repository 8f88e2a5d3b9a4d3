// How often a writer repeats a heartbeat that a reader has not answered, and samples that do not arrive.
//
// A writer of Takt sends a heartbeat every few milliseconds while a reader has not acknowledged every sample,
// so that a lost sample is sent again soon. In Fast DDS 2.9.1, this period is fixed, and the heartbeat goes
// to all readers. If the answer of one reader takes 200 ms, the writer sends 40 heartbeats before the first
// answer arrives; all of them cross the same slow link, the reader answers each, and the link carries nothing
// else. So the writer here sends a heartbeat only to a reader that has not acknowledged everything, and waits
// about as long as this reader's answers take. Only the source files of this room include this header.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include <takt/core/time.hpp>

namespace takt::dds {

/// The heartbeats of one writer for one reader.
class HeartbeatPace {
 public:
  /// The longest time between two heartbeats, if the answers take so long, and before any has arrived. If
  /// answers are lost instead of late, heartbeats that are rarer would delay what was lost.
  static constexpr Nanoseconds kLongest = std::chrono::seconds{1};
  static constexpr Nanoseconds kLongestGuess = std::chrono::milliseconds{200};

  /// `round_trip` is that of another writer for a reader of the same participant; 0: not known.
  explicit HeartbeatPace(Nanoseconds round_trip = Nanoseconds{0}) : round_trip_(round_trip) {}

  /// Returns true if the writer is to send a heartbeat now. `period` is the shortest time between two
  /// heartbeats, and `newest` the number of the writer's newest sample. Each heartbeat without an answer
  /// doubles the time to the next; a new sample shortens it.
  bool is_due(Instant now, Nanoseconds period, std::uint64_t newest) {
    if (newest != newest_) pause_ = std::max(unanswered_ ? pause_ / 4 : Nanoseconds{0}, round_trip_);
    newest_ = newest;
    pause_ = std::max(pause_, period);
    if (sent_ && now - last_ < pause_ - period / 2) return false;
    last_ = now;
    if (!sent_) first_ = now;
    sent_ = unanswered_ = true;
    pause_ = std::min(2 * pause_, std::max(round_trip_, kLongestGuess));
    return true;
  }

  /// The reader has answered. Over a slow link, several heartbeats are on their way before the first answer
  /// arrives, so its time counts from the first one. Otherwise, the reader may have answered an earlier
  /// heartbeat than the last, and then its answers take longer than it seems; so a shorter time counts only
  /// gradually.
  void answered(Instant now) {
    if (!unanswered_) return;
    unanswered_ = false;
    const bool is_slow = round_trip_ == Nanoseconds{0} && now - first_ > kLongestGuess;
    round_trip_ =
        std::min(is_slow ? now - first_ : std::max(2 * (now - last_), round_trip_ * 3 / 4), kLongest);
    pause_ = round_trip_;
  }

  /// Returns the longest time from a heartbeat to its answer that is expected; 0: not known yet.
  [[nodiscard]] Nanoseconds round_trip() const noexcept { return round_trip_; }

 private:
  Nanoseconds round_trip_;
  Nanoseconds pause_{0};
  Instant first_{};
  Instant last_{};
  std::uint64_t newest_ = 0;
  bool sent_ = false;
  bool unanswered_ = false;
};

/// The requests with which one reader asks one writer for a first heartbeat. Fast DDS repeats such a request
/// in a fixed period until the heartbeat arrives.
class FirstRequestPace {
 public:
  static constexpr Nanoseconds kFirst = std::chrono::milliseconds{10};
  static constexpr Nanoseconds kLongest = std::chrono::milliseconds{320};

  /// Returns true if the reader is to send a request now. Each request doubles the time to the next.
  bool is_due(Instant now) {
    const bool is_first = !sent_ || now - last_ > 2 * kLongest;  // also if the reader finds the writer again
    if (!is_first && now - last_ < pause_ - kFirst / 2) return false;
    pause_ = is_first ? kFirst : std::min(2 * pause_, kLongest);
    sent_ = true;
    last_ = now;
    return true;
  }

 private:
  Nanoseconds pause_ = kFirst;
  Instant last_{};
  bool sent_ = false;
};

/// The answers of one writer to one reader that requests the same samples, or the same fragments of a sample,
/// again and again.
class ResendPace {
 public:
  static constexpr Nanoseconds kFirst = std::chrono::milliseconds{10};
  static constexpr Nanoseconds kLongest = std::chrono::seconds{1};
  /// If a reader has missed something for so long, although the writer has sent it so many times, something
  /// on the path drops it. On a network that loses 30 % of all packets, one of 170,000 samples is lost ten
  /// times.
  static constexpr Nanoseconds kStuck = std::chrono::seconds{3};
  static constexpr int kManyTimes = 9;

  /// The reader requests everything from `first` on. Returns true if the writer may answer now. Each answer
  /// to the same request doubles the time to the next. The last answer may be on its way for `round_trip`.
  bool is_due(Instant now, std::uint64_t first, Nanoseconds round_trip = Nanoseconds{0}) {
    if (answers_ == 0 || first != first_) *this = ResendPace{now, first};
    if (answers_ > 0 && now - answered_ < std::max(pause_, round_trip)) return false;
    if (answers_ > 0) pause_ = std::min(2 * pause_, kLongest);
    answered_ = now;
    ++answers_;
    return true;
  }
  /// Returns true if the writer would not answer a request that comes more than `within` from now.
  [[nodiscard]] bool is_paused(Instant now, Nanoseconds within) const {
    return answers_ > 0 && now - answered_ < pause_ - within;
  }
  [[nodiscard]] bool is_stuck(Instant now) const { return now - since_ > kStuck && answers_ > kManyTimes; }

  ResendPace() = default;

 private:
  ResendPace(Instant since, std::uint64_t first) : first_(first), since_(since) {}

  std::uint64_t first_ = 0;  // the first missing sample or fragment
  Instant since_{};          // when the reader began to miss it
  Instant answered_{};
  Nanoseconds pause_ = kFirst;
  int answers_ = 0;
};

}  // namespace takt::dds
