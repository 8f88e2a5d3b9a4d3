// Mean, variance and histogram of durations, which one thread records while other threads read them.
//
// A real-time thread must record durations without locking, and an operator must be able to read consistent
// values from another process at any time. So the values are in one record of fixed size with a single
// writer. A sequence number shows a reader whether the record changed during the read.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace takt {

/// The buckets of a histogram. Each value up to 31 ns has its own bucket. Above 31 ns, each octave has 16
/// buckets (at most 6 % wide), up to 2^40 ns.
struct HistogramScale {
  static constexpr std::size_t kBuckets = 32 + 16 * 35;

  /// Returns the bucket of a value in ns. Negative values count as 0. Values beyond the end of the scale
  /// count in the last bucket.
  static std::size_t bucket(std::int64_t value) noexcept;
  /// Returns the smallest value of a bucket, in ns. lower(kBuckets) is the end of the scale.
  static std::int64_t lower(std::size_t bucket) noexcept;
};

/// A consistent copy of the statistics. Times are in ns.
struct StatisticsSnapshot {
  std::uint64_t count = 0;
  double mean = 0;      ///< mean of the signed values
  double variance = 0;  ///< variance of the signed values, in ns^2
  // min, max and buckets refer to the absolute values.
  std::int64_t min = 0;
  std::int64_t max = 0;
  std::array<std::uint64_t, HistogramScale::kBuckets> buckets{};

  /// Returns the value in ns below which a share `q` (0 to 1) of the absolute values lies; for example, 0.5
  /// gives the median. Interpolates linearly within a bucket. Returns 0 if there are no values.
  [[nodiscard]] double quantile(double q) const noexcept;
};

/// Mean, variance and histogram of durations, updated with each new duration. Suitable for shared memory: it
/// has a standard layout and no pointers, and it is valid when all its bytes are zero. One thread may write,
/// and any number of threads may read.
class Statistics {
 public:
  /// Adds one duration. Does not lock, allocate memory or make system calls, so real-time threads may call
  /// this function. Only one thread at a time may call record().
  void record(std::int64_t value_ns) noexcept;

  /// Returns a copy of the statistics. Any thread of any process may call this. If the values change during
  /// the copy, the function copies them again. After 1000 failed attempts, the writer has probably died
  /// during an update; then the result may lack a part of the last value.
  [[nodiscard]] StatisticsSnapshot read() const noexcept;

 private:
  template <class T>
  using Word = std::atomic<T>;

  Word<std::uint64_t> sequence_;  // odd while the writer updates the values
  Word<std::uint64_t> count_;
  Word<std::int64_t> sum_;
  Word<double> sum_of_squares_;
  Word<std::int64_t> min_;
  Word<std::int64_t> max_;
  std::array<Word<std::uint64_t>, HistogramScale::kBuckets> buckets_;
};

inline std::size_t HistogramScale::bucket(std::int64_t value) noexcept {
  if (value < 32) return value < 0 ? 0 : static_cast<std::size_t>(value);
  const int octave = 63 - __builtin_clzll(static_cast<std::uint64_t>(value));  // at least 5
  const auto step = static_cast<std::size_t>(value >> (octave - 4)) & 15U;
  const std::size_t index = 32 + static_cast<std::size_t>(octave - 5) * 16 + step;
  return index < kBuckets ? index : kBuckets - 1;
}

inline void Statistics::record(std::int64_t value_ns) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  constexpr auto release = std::memory_order_release;
  const auto add = [](auto& word, auto value) { word.store(word.load(relaxed) + value, release); };

  const std::int64_t size = value_ns < 0 ? -value_ns : value_ns;
  // Odd if the former writer died during an update.
  const std::uint64_t sequence = sequence_.load(relaxed) & ~std::uint64_t{1};
  // All stores below are release stores, and read() uses acquire loads. So a reader that sees one of the new
  // values also sees the odd sequence number.
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
