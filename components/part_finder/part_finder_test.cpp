// Tests part_finder with images of known parts.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <takt/testing.hpp>

#include <line.hpp>

#include "../common/beside_threads.hpp"
#include "finder.hpp"

namespace {

using vision::Camera;
using vision::Kind;
using vision::PlacedPart;

/// Returns the angle between two longer sides. A longer side has no direction, so half a turn makes no
/// difference.
double between_axes(double a, double b) {
  const double d = std::remainder(a - b, std::numbers::pi);
  return std::abs(d);
}

struct Worst {
  double place = 0;  // m, error of the position
  double angle = 0;  // rad, error of the angle
};

/// Places one part at random positions in 500 images and returns the largest errors of the search.
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
TEST(PartFinder, FindsBoxesInANoisyImageWithUnevenLight) {
  const Worst worst = worst_of(Kind::box, {.noise = 20, .light = 80});
  EXPECT_LT(worst.place, 0.002);
  EXPECT_LT(worst.angle, 2 * std::numbers::pi / 180);
}
TEST(PartFinder, FindsNothingOnAnEmptyBelt) {
  Camera camera{{.noise = 20, .light = 80}};
  for (int i = 0; i < 200; ++i) EXPECT_TRUE(vision::find_parts(camera.take({}, 0.007 * i), {}).empty()) << i;
}
TEST(PartFinder, IgnoresPartsPartlyOutsideTheImage) {
  Camera camera{{}};
  const std::vector<PlacedPart> parts{{.x = 0.15, .y = 0}, {.x = 0, .y = 0}};
  const auto found = vision::find_parts(camera.take(parts, 0), {});
  ASSERT_EQ(found.size(), 1U);
  EXPECT_NEAR(found[0].x, 0, 0.001);
}
TEST(PartFinder, DistinguishesBoxesFromBottles) {
  Camera camera{{}};
  const std::vector<PlacedPart> parts{{.kind = Kind::box, .x = 0.08, .y = 0.03, .angle = 0.4},
                                      {.kind = Kind::bottle, .x = -0.06, .y = -0.04, .angle = 1.2}};
  const auto found = vision::find_parts(camera.take(parts, 0), {});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].kind, Kind::bottle);
  EXPECT_EQ(found[1].kind, Kind::box);
}
TEST(PartFinder, IgnoresPartsThatTouch) {
  Camera camera{{}};
  const std::vector<PlacedPart> parts{{.x = 0.02, .y = 0}, {.x = -0.05, .y = 0}};
  EXPECT_TRUE(vision::find_parts(camera.take(parts, 0), {}).empty());
}

using namespace std::chrono_literals;

line::Part lying(const char* kind, double x, double y, double angle) {
  line::Part part;
  part.kind(kind);
  part.x(x);
  part.y(y);
  part.angle(angle);
  return part;
}
line::BeltState holding(std::uint32_t number) {
  line::BeltState state;
  state.mode(line::BELT_HOLDING);
  state.parts(number);
  return state;
}

class PartFinderModule : public ::testing::Test {
 protected:
  PartFinderModule() { lies({lying("box", 0.01, -0.02, 0.4), lying("box", -0.14, 0, 0)}); }
  void lies(const std::vector<line::Part>& parts) {
    line::Scene now;
    for (const line::Part& one : parts) now.parts().push_back(one);
    scene.write(now);
  }
  template <class Done>
  bool comes(Done&& done) {
    return common::comes_in_time(module, done);
  }

  takt::testing::Module module{{.period = 40ms}};
  takt::testing::In<line::Scene>& scene = module.in<line::Scene>("scene");
  takt::testing::In<line::BeltState>& belt = module.in<line::BeltState>("belt");
  takt::testing::Out<line::Scene>& seen = module.out<line::Scene>("seen");
  takt::testing::Out<line::Part>& part = module.out<line::Part>("part");
};

TEST_F(PartFinderModule, AnnouncesAWaitingPartOnce) {
  ASSERT_TRUE(module.set("repeat", "3600"));
  ASSERT_TRUE(module.start());
  ASSERT_TRUE(comes([&] { return seen.has_value() && !seen.value().parts().empty(); }));
  EXPECT_FALSE(part.has_value()) << "a part was published although the belt holds no part";
  belt.write(holding(5));
  ASSERT_TRUE(comes([&] { return part.has_value(); }));
  EXPECT_EQ(part.value().number(), 5U);
  EXPECT_EQ(part.value().kind(), "box");
  EXPECT_NEAR(part.value().x(), 0.01, 0.001);
  EXPECT_NEAR(part.value().y(), -0.02, 0.001);
  EXPECT_NEAR(between_axes(part.value().angle(), 0.4), 0, 0.02);
  const std::uint64_t images = seen.count();
  ASSERT_TRUE(comes([&] { return seen.count() >= images + 5; }));
  EXPECT_EQ(part.count(), 1U);
  belt.write(holding(6));
  ASSERT_TRUE(comes([&] { return part.count() == 2; }));
  EXPECT_EQ(part.value().number(), 6U);
}

TEST_F(PartFinderModule, RepeatsTheAnnouncementOfAWaitingPart) {
  ASSERT_TRUE(module.set("repeat", "0.1"));
  ASSERT_TRUE(module.start());
  belt.write(holding(5));
  EXPECT_TRUE(comes([&] { return part.count() == 3; }));
}

TEST_F(PartFinderModule, AnnouncesNoPartIfTheImageShowsNone) {
  lies({});
  ASSERT_TRUE(module.start());
  belt.write(holding(5));
  ASSERT_TRUE(comes([&] { return seen.count() == 10; }));
  EXPECT_FALSE(part.has_value());
}

}  // namespace
