// Simulates the camera over a belt's light barrier: renders an image of the parts near the barrier. The belt
// runs from left to right, and the barrier is in the middle of the image.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace vision {

/// Parameters that the camera and the finder share.
struct Optics {
  int width = 320;      ///< pixels
  int height = 240;     ///< pixels
  double scale = 1000;  ///< pixels per metre on the belt
};

enum class Kind { box, bottle };

/// A part on the belt. Its position is the centre of its area. x: distance to the barrier in m, positive for
/// a part that has not reached the barrier. y: m across the belt from its centre line, downwards in the
/// image. angle: rad from the belt's direction to the longer side.
struct PlacedPart {
  Kind kind = Kind::box;
  double x = 0;
  double y = 0;
  double angle = 0;
};

/// Dimensions of the parts, seen from above, in m.
inline constexpr double kBoxLength = 0.08;
inline constexpr double kBoxWidth = 0.05;
inline constexpr double kBodyLength = 0.07;
inline constexpr double kBodyWidth = 0.036;
inline constexpr double kNeckLength = 0.03;
inline constexpr double kNeckWidth = 0.014;

class Camera {
 public:
  struct Settings {
    Optics optics{};
    double noise = 6;   ///< standard deviation of a pixel's brightness, in grey levels (0 to 255)
    double light = 30;  ///< brightness difference between the brightest corner and the opposite corner
    std::uint64_t seed = 1;
  };

  explicit Camera(const Settings& settings) : settings_(settings), random_(settings.seed) {}

  /// Returns an 8-bit grey image of these parts on a belt that has moved by `position` m.
  [[nodiscard]] cv::Mat take(std::span<const PlacedPart> parts, double position) {
    cv::Mat image = belt(position);
    for (const PlacedPart& part : parts) draw(image, part);
    cv::Mat noise(image.size(), CV_16SC1);
    random_.fill(noise, cv::RNG::NORMAL, 0, settings_.noise);
    cv::Mat exact;
    image.convertTo(exact, CV_16SC1);
    exact += noise;
    exact.convertTo(image, CV_8UC1);  // clamps to 0 to 255, like a sensor
    return image;
  }

 private:
  /// Draws a dark rubber belt with moving ribs, lit from the upper left.
  [[nodiscard]] cv::Mat belt(double position) const {
    const Optics& optics = settings_.optics;
    cv::Mat image(optics.height, optics.width, CV_8UC1);
    constexpr double kRib = 0.02;  // m, distance between two ribs
    for (int v = 0; v < optics.height; ++v) {
      auto* row = image.ptr<std::uint8_t>(v);
      for (int u = 0; u < optics.width; ++u) {
        const double along = u / optics.scale - position;
        const double rib = 5 * std::sin(2 * std::numbers::pi * along / kRib);
        row[u] = cv::saturate_cast<std::uint8_t>(50 + rib + light(u, v));
      }
    }
    return image;
  }

  [[nodiscard]] double light(double u, double v) const {
    return settings_.light * (1 - (u / settings_.optics.width + v / settings_.optics.height) / 2);
  }

  void draw(cv::Mat& image, const PlacedPart& part) const {
    if (part.kind == Kind::box) {
      draw_rectangle(image, part, 0, kBoxLength, kBoxWidth, 190);
      return;
    }
    // The position of a bottle is the common centre of its body and its neck.
    const double body = kBodyLength * kBodyWidth;
    const double neck = kNeckLength * kNeckWidth;
    const double apart = (kBodyLength + kNeckLength) / 2;
    draw_rectangle(image, part, -apart * neck / (body + neck), kBodyLength, kBodyWidth, 170);
    draw_rectangle(image, part, apart * body / (body + neck), kNeckLength, kNeckWidth, 170);
  }

  /// Draws a rectangle. Its centre is on the part's longer axis, `along` m from the part's centre.
  void draw_rectangle(cv::Mat& image, const PlacedPart& part, double along, double length, double width,
                      int brightness) const {
    const Optics& optics = settings_.optics;
    constexpr int kShift = 8;  // corners are in units of 1/256 pixel
    const double c = std::cos(part.angle);
    const double s = std::sin(part.angle);
    const double u = optics.width / 2.0 - part.x * optics.scale;
    const double v = optics.height / 2.0 + part.y * optics.scale;
    std::array<cv::Point, 4> corners;
    constexpr std::array<std::array<double, 2>, 4> kSigns{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const double a = along + kSigns[i][0] * length / 2;
      const double b = kSigns[i][1] * width / 2;
      // In `corners`, whole numbers are pixel centres; in `u` and `v`, they are pixel edges.
      corners[i] = {cvRound((u + (a * c - b * s) * optics.scale - 0.5) * (1 << kShift)),
                    cvRound((v + (a * s + b * c) * optics.scale - 0.5) * (1 << kShift))};
    }
    const double lit = brightness + light(u, v);
    cv::fillConvexPoly(image, corners.data(), 4, cv::Scalar(lit), cv::LINE_AA, kShift);
  }

  Settings settings_;
  cv::RNG random_;
};

}  // namespace vision
