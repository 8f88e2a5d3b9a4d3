#include "blob.hpp"

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

namespace vision {
namespace {

TEST(Blob, IsFoundWithinATenthOfAPixel) {
  Frame frame;
  Noise noise;
  for (int step = 0; step < 200; ++step) {
    const Spot part{48 + 24 * std::cos(step * 0.0317), 32 + 18 * std::sin(step * 0.0317)};
    render(frame, part, 8, 10, noise);
    const auto blob = find(frame, 100, 10);
    ASSERT_TRUE(blob) << step;
    EXPECT_NEAR(blob->centre.x, part.x, 0.1) << step;
    EXPECT_NEAR(blob->centre.y, part.y, 0.1) << step;
  }
}

TEST(Blob, HasTheAreaOfItsDisc) {
  Frame frame;
  Noise noise;
  render(frame, {48, 32}, 8, 0, noise);
  const auto blob = find(frame, 100, 10);
  ASSERT_TRUE(blob);
  EXPECT_NEAR(blob->area, 3.1416 * 8 * 8, 15);
}

TEST(Blob, IsNotFoundInAnEmptyImage) {
  Frame frame;
  Noise noise;
  render(frame, {-100, -100}, 8, 20, noise);
  EXPECT_FALSE(find(frame, 100, 10));
}

TEST(Blob, IsNotFoundIfItHasTooFewPixels) {
  Frame frame;
  for (int x = 10; x < 19; ++x) frame.at(x, 5) = 255;
  EXPECT_FALSE(find(frame, 100, 10));
  frame.at(19, 5) = 255;
  EXPECT_TRUE(find(frame, 100, 10));
}

TEST(Blob, IsFoundAtTheEdgeOfTheImage) {
  Frame frame;
  Noise noise;
  render(frame, {0, 0}, 8, 0, noise);
  const auto blob = find(frame, 100, 10);
  ASSERT_TRUE(blob);
  EXPECT_GE(blob->centre.x, 0);
  EXPECT_LT(blob->centre.x, 8);
}

TEST(Noise, AveragesToZero) {
  Noise noise;
  double sum = 0;
  for (int i = 0; i < 100000; ++i) {
    const double value = noise.next();
    ASSERT_GE(value, -1);
    ASSERT_LE(value, 1);
    sum += value;
  }
  EXPECT_NEAR(sum / 100000, 0, 0.01);
}

using namespace std::chrono_literals;

TEST(Vision, FindsThePartInEveryImage) {
  takt::testing::Module module{{.period = 1ms, .sporadic = true}};
  ASSERT_TRUE(module.set("every", "10"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(4000), 4000U);
  testing::internal::CaptureStdout();
  ASSERT_TRUE(module.destruct());
  unsigned frames = 0, releases = 0, lost = 1;
  double error = 0;
  ASSERT_EQ(std::sscanf(testing::internal::GetCapturedStdout().c_str(),
                        "vision: %u frames in %u releases, largest error %lf px, lost %u", &frames, &releases,
                        &error, &lost),
            4);
  EXPECT_EQ(frames, 400U);
  EXPECT_EQ(releases, 4000U);
  EXPECT_GT(error, 0);
  EXPECT_LT(error, 0.2);
  EXPECT_EQ(lost, 0U);
}

TEST(Vision, DoesNotStartAsAPeriodicModule) {
  takt::testing::Module module;
  EXPECT_FALSE(module.start());
}

}  // namespace
}  // namespace vision
