// Functions that fill a samples::Count and check it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include <samples.hpp>

inline void fill(samples::Count& count, std::uint64_t number) {
  count.number(number);
  for (double& same : count.same()) same = static_cast<double>(number);
  count.few().assign(number % 5, static_cast<std::uint32_t>(number));
}

/// Returns true if all fields have the values that belong to the number of the sample.
inline bool is_whole(const samples::Count& count) {
  const std::uint64_t number = count.number();
  for (const double same : count.same()) {
    if (same != static_cast<double>(number)) return false;
  }
  if (count.few().size() != number % 5) return false;
  for (const std::uint32_t few : count.few()) {
    if (few != static_cast<std::uint32_t>(number)) return false;
  }
  return true;
}

/// Statistics of the samples that a reader has read.
struct Seen {
  std::uint64_t read = 0;
  std::uint64_t first = 0;
  std::uint64_t last = 0;
  std::uint64_t gaps = 0;   ///< number of samples that the reader missed
  std::uint64_t wrong = 0;  ///< number of samples that were torn or out of order
  std::int64_t oldest_ns = 0;
  std::array<std::uint32_t, 10'000>
      ages_us{};  ///< sample counts by age when read, in us; the last entry counts all older ones

  void take(const samples::Count& count, std::int64_t age_ns) {
    if (!is_whole(count) || (read != 0 && count.number() <= last)) ++wrong;
    if (read == 0) first = count.number();
    if (read != 0 && count.number() > last) gaps += count.number() - last - 1;
    last = count.number();
    if (age_ns > oldest_ns) oldest_ns = age_ns;
    ++ages_us[std::min<std::size_t>(static_cast<std::size_t>(age_ns / 1000), ages_us.size() - 1)];
    ++read;
  }
  /// Returns the age in us that this fraction (0 to 1) of the samples did not exceed.
  [[nodiscard]] std::size_t age_us(double part) const {
    std::uint64_t sum = 0;
    std::size_t us = 0;
    while (us < ages_us.size() - 1 &&
           static_cast<double>(sum += ages_us[us]) < part * static_cast<double>(read)) {
      ++us;
    }
    return us;
  }
};
