// What part_finder sees in pictures whose truth is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "finder.hpp"

namespace {

using vision::Camera;
using vision::Kind;
using vision::PlacedPart;

/// A part's longer side has no direction: half a turn is none.
double between_axes(double a, double b) {
  const double d = std::remainder(a - b, std::numbers::pi);
  return std::abs(d);
}

struct Worst {
  double place = 0;  // m
  double angle = 0;  // rad
};

/// Places one part at random, 500 times, and looks for it.
Worst worst_of(Kind kind, Camera::Settings settings) {
  Camera camera{settings};
  std::mt19937_64 random{7};
  std::uniform_real_distribution<double> across{-0.045, 0.045};
  std::uniform_real_distribution<double> turn{-std::numbers::pi, std::numbers::pi};
  Worst worst;
  for (int i = 0; i < 500; ++i) {
    const PlacedPart truth{.kind = kind, .x = across(random), .y = across(random), .angle = turn(random)};
    const auto found = vision::find_parts(camera.take(std::vector{truth}, 0.013 * i), {});
    EXPECT_EQ(found.size(), 1U) << "number " << i << " at " << truth.x << ", " << truth.y << ", turned "
                                << truth.angle;
    if (found.size() != 1) continue;
    EXPECT_EQ(found[0].kind, kind);
    worst.place = std::max(worst.place, std::hypot(found[0].x - truth.x, found[0].y - truth.y));
    worst.angle = std::max(worst.angle, between_axes(found[0].angle, truth.angle));
  }
  return worst;
}

TEST(PartFinder, FindsEveryBoxWithinAMillimetreAndADegree) {
  const Worst worst = worst_of(Kind::box, {});
  EXPECT_LT(worst.place, 0.001);
  EXPECT_LT(worst.angle, std::numbers::pi / 180);
  RecordProperty("worst_place_um", static_cast<int>(worst.place * 1e6));
  RecordProperty("worst_angle_mrad", static_cast<int>(worst.angle * 1e3));
}
TEST(PartFinder, FindsEveryBottleWithinAMillimetreAndADegree) {
  const Worst worst = worst_of(Kind::bottle, {});
  EXPECT_LT(worst.place, 0.001);
  EXPECT_LT(worst.angle, std::numbers::pi / 180);
}
TEST(PartFinder, FindsThemInANoisyPictureUnderASlantingLight) {
  const Worst worst = worst_of(Kind::box, {.noise = 20, .light = 80});
  EXPECT_LT(worst.place, 0.002);
  EXPECT_LT(worst.angle, 2 * std::numbers::pi / 180);
}
TEST(PartFinder, SeesNothingOnAnEmptyBelt) {
  Camera camera{{.noise = 20, .light = 80}};
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(vision::find_parts(camera.take({}, 0.007 * i), {}).empty()) << i;
}
TEST(PartFinder, PassesOverWhatIsPartlyOutOfThePicture) {
  Camera camera{{}};
  const std::vector<PlacedPart> parts{{.x = 0.15, .y = 0}, {.x = 0, .y = 0}};
  const auto found = vision::find_parts(camera.take(parts, 0), {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].x, 0, 0.001);
}
TEST(PartFinder, TellsSeveralApart) {
  Camera camera{{}};
  const std::vector<PlacedPart> parts{{.kind = Kind::box, .x = 0.08, .y = 0.03, .angle = 0.4},
                                      {.kind = Kind::bottle, .x = -0.06, .y = -0.04, .angle = 1.2}};
  const auto found = vision::find_parts(camera.take(parts, 0), {});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].kind, Kind::bottle);
  EXPECT_EQ(found[1].kind, Kind::box);
}
TEST(PartFinder, TakesTwoThatTouchForNone) {
  Camera camera{{}};
  const std::vector<PlacedPart> parts{{.x = 0.02, .y = 0}, {.x = -0.05, .y = 0}};
  EXPECT_TRUE(vision::find_parts(camera.take(parts, 0), {}).empty());
}

}  // namespace
