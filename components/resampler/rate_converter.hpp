// The mathematics of the component resampler: converts samples from one period to another. Real-time threads
// may use everything here.
#pragma once

#include <algorithm>
#include <cstdint>

namespace resampler {

enum class Method {
  hold,     ///< the newest sample
  linear,   ///< a point on the line between the last two samples, one input interval late
  average,  ///< the mean of the samples since the last output
};

/// Converts a signal. add() takes the samples in order of time, with the times at which they were written.
/// output() may be called at other times than those of the samples.
class RateConverter {
 public:
  void add(double value, std::int64_t time_ns) noexcept {
    // Assumes that the signal already had this value before its first sample.
    before_ = count_ == 0 ? value : newest_;
    before_ns_ = count_ == 0 ? time_ns : newest_ns_;
    newest_ = value;
    newest_ns_ = time_ns;
    if (count_ == 0) mean_ = value;
    ++count_;
    ++fresh_;
    sum_ += value;
  }
  void reset() noexcept { *this = {}; }
  /// Returns true if add() has been called.
  [[nodiscard]] bool begun() const noexcept { return count_ > 0; }

  /// Computes the next output. Call this once per output, and only if begun() returns true.
  double output(Method method, std::int64_t now_ns) noexcept {
    if (fresh_ > 0) mean_ = sum_ / static_cast<double>(fresh_);
    fresh_ = 0;
    sum_ = 0;
    switch (method) {
      case Method::hold:
        return newest_;
      case Method::linear: {
        const std::int64_t interval = newest_ns_ - before_ns_;
        if (interval <= 0) return newest_;
        const double part = static_cast<double>(now_ns - newest_ns_) / static_cast<double>(interval);
        return before_ + std::clamp(part, 0.0, 1.0) * (newest_ - before_);
      }
      case Method::average:
        return mean_;
    }
    return newest_;
  }

 private:
  double before_ = 0, newest_ = 0;
  std::int64_t before_ns_ = 0, newest_ns_ = 0;
  std::uint64_t count_ = 0;
  std::uint64_t fresh_ = 0;  // number of samples since the last output
  double sum_ = 0, mean_ = 0;
};

}  // namespace resampler
