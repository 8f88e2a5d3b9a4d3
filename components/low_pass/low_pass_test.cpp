#include "low_pass_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"
#include "../common/frequency_response.hpp"

namespace low_pass {
namespace {

using common::number;
using std::chrono::milliseconds;

/// Returns the theoretical response of a Butterworth filter after a bilinear transform that is prewarped at
/// the cut-off frequency.
std::complex<double> theory(double frequency, double cutoff, double period, int order) {
  const std::complex<double> s(
      0, std::tan(std::numbers::pi * frequency * period) / std::tan(std::numbers::pi * cutoff * period));
  return order == 1 ? 1.0 / (1.0 + s) : 1.0 / (s * s + std::numbers::sqrt2 * s + 1.0);
}

TEST(LowPassFilter, MatchesTheTheoreticalResponse) {
  constexpr int kWindow = 1000;
  for (const double period : {1e-4, 1e-3, 0.05}) {
    for (const int order : {1, 2}) {
      for (const double part : {0.01, 0.1, 0.25, 0.45}) {  // cut-off as a fraction of the sampling rate
        for (const int cycles : {1, 5, 10, 100, 250, 450, 499}) {
          LowPassFilter filter;
          filter.design(part / period, period, order);
          const auto response = common::frequency_response([&](double x) { return filter.step(x); }, cycles,
                                                           kWindow, 3 * kWindow);
          const auto expected = theory(cycles / (kWindow * period), part / period, period, order);
          ASSERT_NEAR(std::abs(response - expected), 0, 1e-9)
              << period << " " << order << " " << part << " " << cycles;
        }
      }
    }
  }
}

TEST(LowPassFilter, PassesHalfThePowerAtItsCutoff) {
  for (const int order : {1, 2}) {
    LowPassFilter filter;
    filter.design(200, 1e-3, order);
    const auto response =
        common::frequency_response([&](double x) { return filter.step(x); }, 200, 1000, 2000);
    EXPECT_NEAR(std::norm(response), 0.5, 1e-12);
  }
}

TEST(LowPassFilter, BeginsAtItsFirstInput) {
  for (const int order : {1, 2}) {
    LowPassFilter filter;
    filter.design(1, 1e-3, order);
    for (int i = 0; i < 100; ++i) EXPECT_NEAR(filter.step(7.5), 7.5, 1e-12);
  }
}

TEST(LowPassFilter, ReachesAConstantInputEvenAtTheLowestCutoff) {
  for (const int order : {1, 2}) {
    LowPassFilter filter;
    filter.design(kLowest * 1000, 1e-3, order);
    filter.step(0);
    double output = 0;
    for (int i = 0; i < 10'000'000; ++i) output = filter.step(1);
    EXPECT_NEAR(output, 1, 1e-6);
  }
}

TEST(LowPassFilter, ChangesItsCutoffAndOrderWithoutAJump) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> cutoff(0.5, 20);
  LowPassFilter filter;
  filter.design(5, 1e-3, 2);
  double last = filter.step(0);
  for (int i = 1; i < 20000; ++i) {
    if (i % 37 == 0) filter.design(cutoff(random), 1e-3, i % 2 + 1);
    const double now = filter.step(std::sin(i * 2e-3));
    // A sine of amplitude 1 at 2 rad/s, filtered at up to 20 Hz, changes by far less than 0.1 in a
    // millisecond.
    ASSERT_LT(std::abs(now - last), 0.1) << i;
    last = now;
  }
}

TEST(LowPass, FiltersItsInputWithTheGivenCutoff) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.set("cutoff", "30"));
  ASSERT_TRUE(module.start());
  module.step(5);
  EXPECT_FALSE(out.has_value());  // no output, because no input has arrived
  LowPassFilter filter;
  filter.design(30, 1e-3, 2);
  std::mt19937 random(2);
  std::normal_distribution<double> noise;
  for (int i = 0; i < 3000; ++i) {
    const double value = noise(random);
    in.write(number(value));
    module.step();
    ASSERT_DOUBLE_EQ(out.value().value(), filter.step(value)) << i;
  }
}

TEST(LowPass, MakesUpForMissedReleasesWithTheLastInput) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(0));
  module.step();
  in.write(number(1));
  module.miss(4);
  module.step();
  LowPassFilter filter;
  filter.design(10, 1e-3, 2);
  filter.step(0);
  double expected = 0;
  for (int i = 0; i < 5; ++i) expected = filter.step(1);
  EXPECT_DOUBLE_EQ(out.value().value(), expected);
}

TEST(LowPass, RejectsACutoffTooHighForItsPeriod) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  ASSERT_TRUE(module.set("cutoff", "50"));
  const auto start = module.start();
  ASSERT_FALSE(start.ok());
  EXPECT_EQ(start.text(),
            "property 'cutoff' cannot be '50'; it takes a number, 1e-04 to 49 at a period of 10 ms, in Hz");
}

TEST(LowPass, RejectsANewCutoffTooHighForItsPeriodWhileItRuns) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  ASSERT_TRUE(module.start());
  EXPECT_FALSE(module.set("cutoff", "60").ok());
  EXPECT_TRUE(module.set("cutoff", "40"));
}

TEST(LowPass, RestartsItsFilterAfterANonFiniteInput) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(3));
  module.step(10);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    in.write(number(bad));
    module.step();
    EXPECT_EQ(module.last_error().text, "the input is not a finite number");
    in.write(number(8));
    ASSERT_TRUE(module.recover());
    module.step();
    EXPECT_NEAR(out.value().value(), 8, 1e-12);
  }
}

}  // namespace
}  // namespace low_pass
