// The flight record: the latest actions of the executor threads, in memory that the node keeps when the host
// dies. Each thread has its own ring, in which the newest entry replaces the oldest. A reader of a ring never
// stops the ring's writer.
#pragma once

#include <atomic>
#include <cstdint>

namespace takt::channel {

enum class FlightKind : std::uint8_t {
  nothing,
  row,       ///< a row began; value: its delay from the planned instant, in ns
  run,       ///< a run() ended; value: its duration, in ns
  row_end,   ///< a row ended, after all its modules and conditions
  released,  ///< the scheduler released a process module, or found it still in its body; value: a Release
  body,      ///< a body of a process module (the work of one release) ended; the entry's time is the end of
             ///< the body, but it is recorded later; value: duration of the body, in ns
  ready,     ///< a sporadic module became ready to run
  write,     ///< a run(), whose `run` entry follows, wrote a sample; value: index of the port in its module
  event,     ///< a run(), whose `run` entry follows, took an event; value: index of the port in its module
  swapped,   ///< from this row on, the executor calls the new instance of a swapped module
};
inline constexpr std::uint8_t kFlightKinds = 10;

/// An entry as it is stored in the ring.
struct FlightEntry {
  std::atomic<std::int64_t> time_ns;  ///< monotonic clock, in ns
  std::atomic<std::uint64_t> what;    ///< kind, module and value, as FlightWriter::pack() returns them
};

/// An entry as a reader gets it.
struct FlightSample {
  std::int64_t time_ns = 0;
  FlightKind kind = FlightKind::nothing;
  std::uint32_t module = 0;  ///< index of the module on the device; 0 for rows
  std::uint64_t value = 0;
  bool operator==(const FlightSample&) const = default;
};

struct alignas(64) FlightRing {
  std::atomic<std::uint64_t> written;  ///< number of entries written so far
};

/// Writes the entries of one thread into its ring. A ring has at most one writer at a time. A
/// default-constructed writer has no ring and records nothing.
class FlightWriter {
 public:
  /// The largest module index and the largest value that an entry can hold. A larger index or value is
  /// recorded as this maximum.
  static constexpr std::uint32_t kMostModule = (1U << 20) - 1;
  static constexpr std::uint64_t kMostValue = (std::uint64_t{1} << 40) - 1;

  FlightWriter() = default;
  /// `capacity`: the number of entries in the ring, a power of two.
  FlightWriter(FlightRing& ring, FlightEntry* entries, std::uint64_t capacity) noexcept
      : ring_(&ring),
        entries_(entries),
        mask_(capacity - 1),
        written_(ring.written.load(std::memory_order_relaxed)) {}

  /// Adds an entry, which replaces the oldest one in a full ring. A real-time thread may call it.
  void add(FlightKind kind, std::int64_t time_ns, std::uint32_t module = 0, std::int64_t value = 0) noexcept {
    if (ring_ == nullptr) return;
    FlightEntry& entry = entries_[written_ & mask_];
    // Each store is a release store. So a reader that sees any part of this entry also sees how many entries
    // were written before this one, and therefore which entry this one replaced.
    entry.time_ns.store(time_ns, std::memory_order_release);
    entry.what.store(pack(kind, module, value), std::memory_order_release);
    ring_->written.store(++written_, std::memory_order_release);
    __builtin_prefetch(entries_ + ((written_ + 4) & mask_), 1);
  }

  static constexpr std::uint64_t pack(FlightKind kind, std::uint32_t module, std::int64_t value) noexcept {
    const std::uint64_t v = value < 0 ? 0 : static_cast<std::uint64_t>(value);
    return std::uint64_t{static_cast<std::uint8_t>(kind)} << 60 |
           std::uint64_t{module < kMostModule ? module : kMostModule} << 40 |
           (v < kMostValue ? v : kMostValue);
  }
  static FlightSample unpack(std::int64_t time_ns, std::uint64_t what) noexcept;

 private:
  FlightRing* ring_ = nullptr;
  FlightEntry* entries_ = nullptr;
  std::uint64_t mask_ = 0;
  std::uint64_t written_ = 0;
};

}  // namespace takt::channel
