// What a module itself reports to the node: its log records, and whether it is in a safe stop. The module's
// threads add records; the node reads the records and formats their text. A record holds the format and
// copies of the arguments, so logging costs a real-time thread only some stores. The memory outlives the
// module's process, so the last records before a crash are not lost.
//
// The module's process may write anything into this memory. So the reader must check everything that it reads
// (host/log_reader.hpp).
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <takt/core/log_level.hpp>

namespace takt::channel {

/// The type of a log argument.
enum class LogArgumentKind : std::uint8_t { none, boolean, character, integer, natural, real, text };

/// An argument of a log call, before it is copied into a record.
struct LogArgument {
  LogArgumentKind kind = LogArgumentKind::none;
  std::uint64_t bits = 0;      ///< the value; for `real` the bits of a double, for `text` its size in bytes
  const char* text = nullptr;  ///< the text of an argument of kind `text`; need not be zero-terminated
};

/// A number of log lines for each LogLevel. Index 0 counts lines whose level is not known.
inline constexpr std::size_t kLogCounts = 5;
using LogCounts = std::array<std::uint64_t, kLogCounts>;

/// One record. If the format and the text arguments do not fit into `text`, their end is cut off.
struct alignas(64) LogRecord {
  static constexpr std::size_t kArguments = 8;
  static constexpr std::size_t kText = 216;

  /// Twice the number of rounds in which this record was read, plus 1 while the record waits for the reader.
  /// The writer stores this word after all members below.
  std::atomic<std::uint64_t> state;
  std::int64_t time_ns;  ///< when the run that logs began, in ns of the monotonic clock
  std::uint64_t cycle;   ///< Cycle::number
  std::uint8_t level;    ///< a LogLevel
  std::uint8_t percent;  ///< 1: the format is that of printf(); 0: that of std::format
  std::uint8_t arguments;
  std::uint8_t format_size;
  std::array<LogArgumentKind, kArguments> kinds;
  /// The values of the arguments. For a text argument, the upper 32 bits are its position in `text`, and the
  /// lower 32 bits its size.
  std::array<std::uint64_t, kArguments> values;
  std::array<char, kText> text;  ///< the format, then the text arguments
};

/// A bounded ring of records. Initially all bytes are zero: the ring is empty and has the default level.
struct alignas(64) LogRing {
  static constexpr std::size_t kRecords = 64;
  /// Only errors and warnings may use the last kReserved free records, so that other lines cannot displace
  /// them.
  static constexpr std::size_t kReserved = 16;

  std::atomic<std::uint32_t> level;      ///< the least important LogLevel that is recorded; 0 means
                                         ///< kDefaultLogLevel
  std::atomic<std::uint32_t> safe_stop;  ///< 1 if the module reports that it is in a safe stop; otherwise 0
  std::atomic<std::uint64_t> claimed;    ///< number of records that writers have taken
  /// By LogLevel: number of log calls that found the ring full.
  std::array<std::atomic<std::uint64_t>, kLogCounts> dropped;
  std::array<LogRecord, kRecords> records;

  [[nodiscard]] std::uint32_t threshold() const noexcept {
    const std::uint32_t set = level.load(std::memory_order_relaxed);
    return set == 0 ? static_cast<std::uint32_t>(kDefaultLogLevel) : set;
  }

  /// A log call without its arguments.
  struct Line {
    std::uint8_t level;
    bool percent;
    std::int64_t time_ns;
    std::uint64_t cycle;
    const char* format;
    std::size_t format_size;
  };

  /// Adds a record. If the ring is full, counts the record as dropped. Several threads may call this at the
  /// same time. A real-time thread may call it.
  void add(const Line& line, const LogArgument* arguments, std::size_t count) noexcept {
    LogRecord* record = nullptr;
    std::uint64_t free = 0;
    const std::uint64_t reserved = line.level <= static_cast<std::uint8_t>(LogLevel::warning) ? 0 : kReserved;
    std::uint64_t position = claimed.load(std::memory_order_relaxed);
    // Other threads of the module may claim records at the same time. The number of attempts is limited,
    // because a faulty module may have damaged the ring.
    for (int attempt = 0; attempt < 8 && record == nullptr; ++attempt) {
      LogRecord& next = records[position % kRecords];
      free = position / kRecords * 2;
      const std::uint64_t state = next.state.load(std::memory_order_acquire);  // pairs with LogReader::next()
      if (state == free) {
        // The reader frees the records in order. So if this later record is free, the records before it are
        // free, too.
        const std::uint64_t last = position + reserved;
        if (records[last % kRecords].state.load(std::memory_order_relaxed) < last / kRecords * 2) break;
        // Relaxed: `claimed` only distributes the records. `state` says when a record is free or complete.
        if (claimed.compare_exchange_weak(position, position + 1, std::memory_order_relaxed)) record = &next;
      } else if (state < free) {
        break;  // the ring is full: the reader has not read this record yet
      } else {
        position = claimed.load(std::memory_order_relaxed);
      }
    }
    if (record == nullptr) {
      dropped[line.level < kLogCounts ? line.level : 0].fetch_add(1, std::memory_order_relaxed);
      return;
    }
    record->time_ns = line.time_ns;
    record->cycle = line.cycle;
    record->level = line.level;
    record->percent = line.percent ? 1 : 0;
    std::size_t used = line.format_size < LogRecord::kText ? line.format_size : LogRecord::kText;
    std::memcpy(record->text.data(), line.format, used);
    record->format_size = static_cast<std::uint8_t>(used);
    if (count > LogRecord::kArguments) count = LogRecord::kArguments;
    record->arguments = static_cast<std::uint8_t>(count);
    for (std::size_t i = 0; i < count; ++i) {
      const LogArgument& argument = arguments[i];
      record->kinds[i] = argument.kind;
      record->values[i] = argument.bits;
      if (argument.kind != LogArgumentKind::text) continue;
      const std::size_t room = LogRecord::kText - used;
      const std::size_t size = argument.bits < room ? argument.bits : room;
      std::memcpy(record->text.data() + used, argument.text, size);
      record->values[i] = std::uint64_t{used} << 32 | size;
      used += size;
    }
    // This exchange fails only if the reader has skipped this record because the writer took too long.
    record->state.compare_exchange_strong(free, free + 1, std::memory_order_release,
                                          std::memory_order_relaxed);  // pairs with the reader's load
  }
};

}  // namespace takt::channel
