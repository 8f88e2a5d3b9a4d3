#include "timed.hpp"

#include <algorithm>

#include <takt/os/clock.hpp>

namespace takt::bench {

namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kBatch = 200us;

Nanoseconds batch(const std::function<void()>& step, std::size_t times) {
  const Instant begin = os::now();
  for (std::size_t i = 0; i < times; ++i) step();
  return os::now() - begin;
}

}  // namespace

std::vector<double> each_by_turns(Nanoseconds length, const std::vector<std::function<void()>>& steps) {
  std::vector<std::size_t> times;
  for (const auto& step : steps) {
    std::size_t n = 1;
    while (batch(step, n) < kBatch) n *= 2;
    times.push_back(n);
  }
  std::vector<std::vector<double>> seen(steps.size());
  const Instant end = os::now() + length;
  do {
    for (std::size_t i = 0; i < steps.size(); ++i)
      seen[i].push_back(static_cast<double>(batch(steps[i], times[i]).count()) /
                        static_cast<double>(times[i]));
  } while (os::now() < end);
  std::vector<double> medians;
  for (std::vector<double>& batches : seen) {
    const auto middle = batches.begin() + static_cast<std::ptrdiff_t>(batches.size() / 2);
    std::nth_element(batches.begin(), middle, batches.end());
    medians.push_back(*middle);
  }
  return medians;
}

}  // namespace takt::bench
