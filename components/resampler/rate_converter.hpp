// From samples of one period to samples of another. For real-time threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace resampler {

enum class Method {
  hold,     ///< the newest sample
  linear,   ///< on the line between the last two, one interval of theirs later
  average,  ///< the mean of those that came since the last output
};

/// Samples come with the time at which they were written, in the order of time; an output is asked for at
/// times of its own.
class RateConverter {
 public:
  void add(double value, std::int64_t time_ns) noexcept {
    // From its first sample on the signal is taken to have been there before.
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
  /// A sample has come at some time.
  [[nodiscard]] bool begun() const noexcept { return count_ > 0; }

  /// Once for each output. Only when begun().
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
  std::uint64_t fresh_ = 0;  // since the last output
  double sum_ = 0, mean_ = 0;
};

}  // namespace resampler
