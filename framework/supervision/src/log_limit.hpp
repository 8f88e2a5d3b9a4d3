// Limits how many log lines of a module are recorded. Without this limit, the lines would displace the events
// of the fault record. Each level has its own limit, so that lines of level info cannot displace an error.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include <takt/channel/log_ring.hpp>
#include <takt/component/log.hpp>
#include <takt/core/time.hpp>

namespace takt::supervision {

class LogLimit {
 public:
  /// A module can log kBurst lines of each level at once, and kPerSecond lines of each level per second on
  /// average.
  static constexpr double kBurst = 50;
  static constexpr double kPerSecond = 10;
  static constexpr Nanoseconds kReportEvery = std::chrono::seconds{1};

  explicit LogLimit(Instant now) noexcept : credited_(now) { credits_.fill(kBurst); }

  /// Returns true if a line of this level may be recorded at `now`. Otherwise counts the line as left out.
  bool takes(LogLevel level, Instant now) {
    const double seconds = std::chrono::duration<double>(now - credited_).count();
    credited_ = now;
    for (double& credit : credits_) credit = std::min(kBurst, credit + seconds * kPerSecond);
    const auto index = static_cast<std::size_t>(level);
    if (credits_.at(index) < 1) {
      ++left_out_.at(index);
      return false;
    }
    credits_.at(index) -= 1;
    return true;
  }

  /// Counts lines that were lost before they could be recorded.
  void add_lost(const channel::LogCounts& lost) {
    for (std::size_t i = 0; i < lost.size(); ++i) left_out_[i] += lost[i];
  }

  /// Returns a text with the number of lines that were left out since the last report, for each level. None
  /// if no line was left out, or if the last report is less than kReportEvery ago.
  std::optional<std::string> report(Instant now) {
    std::uint64_t all = 0;
    std::string levels;
    for (std::size_t i = 0; i < left_out_.size(); ++i) {
      if (left_out_[i] == 0) continue;
      all += left_out_[i];
      levels += (levels.empty() ? "" : ", ") + std::to_string(left_out_[i]) + " " +
                (i == 0 ? "of unknown level" : takt::to_text(static_cast<LogLevel>(i)));
    }
    if (all == 0 || (reported_ && now - *reported_ < kReportEvery)) return std::nullopt;
    reported_ = now;
    left_out_ = {};
    return std::to_string(all) + (all == 1 ? " log line was" : " log lines were") + " left out: " + levels +
           "; a module can log " + std::to_string(static_cast<int>(kPerSecond)) +
           " lines of each level per second";
  }

 private:
  std::array<double, channel::kLogCounts> credits_{};  // by LogLevel: how many lines may be recorded now
  Instant credited_;                                   // when credits_ last grew
  channel::LogCounts left_out_{};  // number of lines left out since the last report, by level
  std::optional<Instant> reported_;
};

}  // namespace takt::supervision
