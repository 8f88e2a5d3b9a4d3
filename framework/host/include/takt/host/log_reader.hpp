// Reads the log records of a module and formats them as text. Not for real-time threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <takt/channel/log_ring.hpp>
#include <takt/core/log_level.hpp>
#include <takt/core/time.hpp>

namespace takt::host {

struct LogLine {
  LogLevel level = LogLevel::info;
  std::int64_t time_ns = 0;  ///< when the run that logs the line began, on the monotonic clock; not validated
  std::uint64_t release = 0;  ///< Cycle::number; 0 if a hook other than run() logged the line
  std::string text{};         ///< on one line, without control characters
};

/// Reads a log ring; a ring has only one reader. The reader trusts nothing that the ring contains: if a
/// module overwrites the ring, the lines may be wrong or missing, but the reader never reads outside the ring
/// and never hangs.
class LogReader {
 public:
  /// If a writer claims a record and does not publish it within this time, the reader assumes that the writer
  /// has died, and skips the record.
  static constexpr Nanoseconds kPatience = std::chrono::seconds{1};

  explicit LogReader(channel::LogRing& ring) noexcept : ring_(ring) {}

  /// Returns the next line; none if no further line is complete.
  std::optional<LogLine> next(Instant now);
  /// Returns the number of lines lost since the last call, because the ring was full or because the writer of
  /// a line died. The level of a line whose writer died is not known.
  channel::LogCounts lost() noexcept;

 private:
  channel::LogRing& ring_;
  std::uint64_t read_ = 0;  // number of records that were read or skipped
  std::optional<Instant> waits_since_;
  std::uint64_t skipped_ = 0;
  channel::LogCounts dropped_{};  // values of ring_.dropped at the last call of lost()
};

}  // namespace takt::host
