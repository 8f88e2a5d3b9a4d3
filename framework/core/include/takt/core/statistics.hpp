// Mean, variance and histogram of durations, recorded by one thread while others read them.
//
// A real-time thread must record without locking. An operator must be able to read a consistent set of
// numbers at any time, from another process. So the values are in one record of fixed size with a single
// writer, and a sequence number shows the reader whether it read between two updates.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace takt {

/// The buckets of a histogram: exact up to 31 ns, then 16 per octave (at most 6 % wide), up to 2^40 ns.
struct HistogramScale {
  static constexpr std::size_t kBuckets = 32 + 16 * 35;

  /// The bucket of a value in ns. Negative values count as 0. Values past the end go to the last bucket.
  static std::size_t bucket(std::int64_t value) noexcept;
  /// The smallest value of a bucket, in ns. lower(kBuckets) is the end of the scale.
  static std::int64_t lower(std::size_t bucket) noexcept;
};

/// What a reader gets: plain values, in ns.
struct StatisticsSnapshot {
  std::uint64_t count = 0;
  double mean = 0;       ///< of the signed values
  double variance = 0;   ///< of the signed values, in ns^2
  std::int64_t min = 0;  ///< of the absolute values, like all members below
  std::int64_t max = 0;
  std::array<std::uint64_t, HistogramScale::kBuckets> buckets{};

  /// The value below which a share `q` (0 to 1) of the absolute values lies, in ns. Interpolates linearly
  /// within a bucket. 0 if there are no values.
  [[nodiscard]] double quantile(double q) const noexcept;
};

/// A streaming mean, variance and histogram of durations in ns. Made for shared memory: it has a standard
/// layout and no pointers, and is valid when all bytes are zero. One writer, any number of readers.
class Statistics {
 public:
  /// Adds one duration, in ns. Real-time: no lock, no allocation, no system call. Only one thread at a time
  /// may record.
  void record(std::int64_t value_ns) noexcept;

  /// Any thread of any process may call it. Reads again if the writer was writing meanwhile. After 1000
  /// tries, the writer must have died while it was writing. Then the result is off by at most one value.
  [[nodiscard]] StatisticsSnapshot read() const noexcept;

  /// Removes all values. Only the writer may call it, or any thread after the writer has ended.
  void clear() noexcept;

 private:
  template <class T>
  using Word = std::atomic<T>;

  Word<std::uint64_t> sequence_;  // odd while the writer is writing
  Word<std::uint64_t> count_;
  Word<std::int64_t> sum_;
  Word<double> sum_of_squares_;
  Word<std::int64_t> min_;
  Word<std::int64_t> max_;
  std::array<Word<std::uint64_t>, HistogramScale::kBuckets> buckets_;
};

inline std::size_t HistogramScale::bucket(std::int64_t value) noexcept {
  if (value < 32) return value < 0 ? 0 : static_cast<std::size_t>(value);
  const int octave = 63 - __builtin_clzll(static_cast<std::uint64_t>(value));  // 5 and up
  const auto step = static_cast<std::size_t>(value >> (octave - 4)) & 15U;
  const std::size_t index = 32 + static_cast<std::size_t>(octave - 5) * 16 + step;
  return index < kBuckets ? index : kBuckets - 1;
}

inline void Statistics::record(std::int64_t value_ns) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  constexpr auto release = std::memory_order_release;
  const auto add = [](auto& word, auto value) { word.store(word.load(relaxed) + value, release); };

  const std::int64_t size = value_ns < 0 ? -value_ns : value_ns;
  const std::uint64_t sequence = sequence_.load(relaxed);
  // SYNC: statistics. Every store below is a release store, so a reader that sees any of them also sees the
  // odd number.
  sequence_.store(sequence + 1, relaxed);
  const std::uint64_t count = count_.load(relaxed);
  count_.store(count + 1, release);
  add(sum_, value_ns);
  add(sum_of_squares_, static_cast<double>(value_ns) * static_cast<double>(value_ns));
  if (count == 0 || size < min_.load(relaxed)) min_.store(size, release);
  if (size > max_.load(relaxed)) max_.store(size, release);
  add(buckets_[HistogramScale::bucket(size)], std::uint64_t{1});
  sequence_.store(sequence + 2, release);
}

}  // namespace takt
