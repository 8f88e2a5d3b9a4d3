// Random numbers for the simulation, derived from one seed. Each source of randomness has its own stream, so
// an additional draw from one source does not change the others. The numbers are the same with every C++
// library.
#pragma once

#include <cstdint>
#include <string_view>

#include <takt/core/time.hpp>

namespace takt::simulation {

class Draws {
 public:
  /// Begins a stream of random numbers. `whose` names the source. Streams with the same seed and different
  /// names differ.
  Draws(std::uint64_t seed, std::string_view whose) noexcept : state_(seed * 0x9e37'79b9'7f4a'7c15U) {
    for (const char c : whose) state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x0000'0100'0000'01b3U;
  }

  /// Returns the next 64 random bits, by the algorithm SplitMix64.
  std::uint64_t next() noexcept {
    state_ += 0x9e37'79b9'7f4a'7c15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58'476d'1ce4'e5b9U;
    z = (z ^ (z >> 27)) * 0x94d0'49bb'1331'11ebU;
    return z ^ (z >> 31);
  }
  /// Returns a random number in [0, 1).
  double share() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }
  /// Returns a random number in [0, end); `end` must be above 0.
  std::uint64_t below(std::uint64_t end) noexcept { return next() % end; }
  /// Returns a random number in [low, high].
  std::int64_t between(std::int64_t low, std::int64_t high) noexcept {
    return low + static_cast<std::int64_t>(below(static_cast<std::uint64_t>(high - low) + 1));
  }
  Nanoseconds between(Nanoseconds low, Nanoseconds high) noexcept {
    return Nanoseconds{between(low.count(), high.count())};
  }
  bool chance(double probability) noexcept { return share() < probability; }

 private:
  std::uint64_t state_;
};

}  // namespace takt::simulation
