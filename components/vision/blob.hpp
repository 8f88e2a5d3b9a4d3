// The mathematics of the component vision: a simulated camera, and the measurement of a bright disc's centre
// in its images. Lengths are in pixels; the centre of the corner pixel is (0, 0).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace vision {

inline constexpr int kWidth = 96;
inline constexpr int kHeight = 64;

struct Spot {
  double x = 0;
  double y = 0;
};

struct Frame {
  std::array<std::uint8_t, std::size_t{kWidth} * kHeight> pixels{};

  std::uint8_t& at(int x, int y) noexcept {
    return pixels[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)];
  }
  [[nodiscard]] std::uint8_t at(int x, int y) const noexcept {
    return pixels[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)];
  }
};

/// Generates sensor noise: numbers from -1 to 1, the same in every run.
class Noise {
 public:
  double next() noexcept {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    state_ ^= state_ << 5;
    return static_cast<double>(state_) / 2147483648.0 - 1;
  }

 private:
  std::uint32_t state_ = 2463534242;
};

/// Renders a disc of brightness 200, with a rim one pixel wide, on a background of brightness 40. Adds noise
/// of the given amplitude.
inline void render(Frame& frame, Spot centre, double radius, double noise, Noise& source) noexcept {
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double distance = std::hypot(x - centre.x, y - centre.y);
      const double cover = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
      const double light = 40 + 160 * cover + noise * source.next();
      frame.at(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(light), 0L, 255L));
    }
  }
}

struct Blob {
  Spot centre{};
  double area = 0;  ///< number of pixels above the threshold
};

/// Finds the centre of the pixels above the threshold: first moments divided by the zeroth moment. The weight
/// of a pixel is its brightness above the threshold. Returns nothing if fewer than `least` pixels are above
/// the threshold, because so few pixels are only noise.
inline std::optional<Blob> find(const Frame& frame, std::uint8_t threshold, int least) noexcept {
  std::int64_t weight = 0;
  std::int64_t moment_x = 0;
  std::int64_t moment_y = 0;
  int area = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int brighter = frame.at(x, y) - threshold;
      if (brighter <= 0) continue;
      weight += brighter;
      moment_x += std::int64_t{brighter} * x;
      moment_y += std::int64_t{brighter} * y;
      ++area;
    }
  }
  if (area < least || weight == 0) return std::nullopt;
  return Blob{{static_cast<double>(moment_x) / static_cast<double>(weight),
               static_cast<double>(moment_y) / static_cast<double>(weight)},
              static_cast<double>(area)};
}

}  // namespace vision
