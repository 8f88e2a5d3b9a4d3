#include "filter.hpp"

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

namespace control3 {
namespace {

constexpr double kRate = 10000;

/// Returns the gain for a sine of this frequency after the filter has settled.
double gain_at(Biquad filter, double frequency) {
  Oscillator sine(frequency, kRate);
  Detector detector;
  detector.window = 10000;  // holds a whole number of periods of each whole-hertz frequency
  for (int i = 0; i < 20000; ++i) detector.step(filter.step(sine.step()), sine);
  return detector.amplitude;
}

TEST(Oscillator, IsStillExactAfterAMillionSteps) {
  Oscillator sine(180, kRate);
  for (int i = 0; i < 1000000; ++i) sine.step();
  EXPECT_NEAR(std::hypot(sine.x, sine.y), 1, 1e-12);
  EXPECT_NEAR(sine.y, 0, 1e-6);  // after 18000 whole periods
}

TEST(LowPass, PassesLowFrequenciesAndBlocksHighFrequencies) {
  const Biquad filter = Biquad::low_pass(1000, 0.7071, kRate);
  EXPECT_NEAR(gain_at(filter, 2), 1, 1e-3);
  EXPECT_NEAR(gain_at(filter, 1000), 0.7071, 1e-3);
  EXPECT_LT(gain_at(filter, 4000), 0.02);
}

TEST(Notch, RemovesOnlyItsFrequency) {
  const Biquad filter = Biquad::notch(180, 2, kRate);
  EXPECT_LT(gain_at(filter, 180), 1e-6);
  EXPECT_NEAR(gain_at(filter, 2), 1, 1e-3);
  EXPECT_NEAR(gain_at(filter, 3000), 1, 1e-3);
}

TEST(Notch, PassesHalfThePowerAtTheEdgesOfItsBand) {
  // The notch at 180 Hz is 90 Hz wide. Its edges are 90 Hz apart, and their product is 180^2.
  const Biquad filter = Biquad::notch(180, 2, kRate);
  EXPECT_NEAR(gain_at(filter, 141), 0.7071, 0.01);
  EXPECT_NEAR(gain_at(filter, 231), 0.7071, 0.01);
}

TEST(Biquad, RejectsInvalidDesignValues) {
  EXPECT_THROW(Biquad::notch(0, 1, kRate), std::invalid_argument);
  EXPECT_THROW(Biquad::notch(5000, 1, kRate), std::invalid_argument);
  EXPECT_THROW(Biquad::low_pass(100, 0, kRate), std::invalid_argument);
  EXPECT_NO_THROW(Biquad::low_pass(4999, 0.7, kRate));
}

TEST(Detector, MeasuresOneOfTwoMixedSines) {
  Oscillator slow(2, kRate);
  Oscillator fast(180, kRate);
  Detector detector;
  detector.window = 5000;
  for (int i = 0; i < 5000; ++i) {
    const double signal = 10 * slow.step() + 2 * fast.step();
    detector.step(signal, fast);
  }
  EXPECT_NEAR(detector.amplitude, 2, 0.01);
}

using namespace std::chrono_literals;

TEST(Control3, KeepsTheResonanceOutOfTheTorque) {
  takt::testing::Module module{{.period = 100us}};
  ASSERT_TRUE(module.start());
  module.step(20'000);
  testing::internal::CaptureStderr();
  ASSERT_TRUE(module.destruct());
  double before = 0, after = -1;
  ASSERT_EQ(std::sscanf(testing::internal::GetCapturedStderr().c_str(),
                        "control3: resonance %lf N m before the filters, %lf N m after", &before, &after),
            2);
  EXPECT_NEAR(before, 2, 0.01);
  EXPECT_GE(after, 0);
  EXPECT_LT(after, 0.05);
}

TEST(Control3, RejectsANotchFrequencyAtHalfTheSamplingRate) {
  takt::testing::Module module{{.period = 100us}};
  ASSERT_TRUE(module.set("notch_hz", "5000"));
  EXPECT_EQ(module.start().text(),
            "property 'notch_hz' cannot be '5000'; it takes a number, 1 to 4999, in Hz");
}

}  // namespace
}  // namespace control3
