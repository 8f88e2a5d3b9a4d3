// Converts samples from one period to another. For real-time threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace resampler {

enum class Method {
  hold,     ///< the newest sample
  linear,   ///< a point on the line between the last two samples, one input interval late
  average,  ///< the mean of the samples since the last output
};

/// add() takes samples with the times at which they were written, in order of time. output() may be called at
/// any other times.
class RateConverter {
 public:
  void add(double value, std::int64_t time_ns) noexcept {
    // Assume that the signal had its first value before, too.
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
  /// True once there was a sample.
  [[nodiscard]] bool begun() const noexcept { return count_ > 0; }

  /// Computes an output. Call it once per output, and only if begun().
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
  std::uint64_t fresh_ = 0;  // samples since the last output
  double sum_ = 0, mean_ = 0;
};

}  // namespace resampler
