#include "rate_converter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace resampler {
namespace {

using common::number;
using std::chrono::microseconds;
using std::chrono::milliseconds;

TEST(RateConverter, HoldsTheNewestSample) {
  RateConverter converter;
  converter.add(1, 0);
  converter.add(2, 10);
  EXPECT_EQ(converter.output(Method::hold, 10), 2);
  EXPECT_EQ(converter.output(Method::hold, 1000), 2);
}

TEST(RateConverter, InterpolatesLinearlyOneIntervalLate) {
  RateConverter converter;
  for (int i = 0; i <= 100; ++i) {
    converter.add(3.0 * i * i, i * 1000);
    if (i == 0) continue;
    for (int t = 0; t < 1000; t += 125) {
      const double part = t / 1000.0;
      const double expected = 3.0 * (i - 1) * (i - 1) * (1 - part) + 3.0 * i * i * part;
      ASSERT_NEAR(converter.output(Method::linear, i * 1000 + t), expected, 1e-9);
    }
  }
  // The converter does not extrapolate beyond the newest sample.
  EXPECT_EQ(converter.output(Method::linear, 1'000'000), 3.0 * 100 * 100);
}

TEST(RateConverter, AveragesTheSamplesSinceTheLastOutput) {
  RateConverter converter;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-1, 1);
  std::uniform_int_distribution<int> number(0, 6);
  double held = 0;
  std::int64_t now = 0;
  converter.add(0, now);
  static_cast<void>(converter.output(Method::average, now));
  for (int i = 0; i < 5000; ++i) {
    double sum = 0;
    const int samples = number(random);
    for (int k = 0; k < samples; ++k) {
      const double x = value(random);
      converter.add(x, now += 3);
      sum += x;
    }
    if (samples > 0) held = sum / samples;
    ASSERT_DOUBLE_EQ(converter.output(Method::average, now), held);
  }
}

TEST(RateConverter, SuppressesMultiplesOfTheOutputRateInItsAverage) {
  // With 10 samples per output, frequencies of 1/10, 2/10, ... of the input rate would alias to 0 Hz.
  for (int k = 1; k <= 5; ++k) {
    RateConverter converter;
    for (int i = 0; i < 1000; ++i) {
      converter.add(std::sin(2 * std::numbers::pi * k / 10 * i + 0.3), i);
      if (i % 10 == 9) {
        ASSERT_NEAR(converter.output(Method::average, i), 0, 1e-12) << k;
      }
    }
  }
}

TEST(Resampler, AveragesEverySampleInItsQueue) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Number>("in", {.queue = 16});
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.set("method", "average"));
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_FALSE(out.has_value());
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 10; ++k) in.write(number(i * 10 + k), milliseconds{10 - k});
    module.step();
    ASSERT_DOUBLE_EQ(out.value().value(), i * 10 + 4.5);
  }
}

TEST(Resampler, InterpolatesBetweenSlowSamples) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.set("method", "linear"));
  ASSERT_TRUE(module.start());
  // The input is a ramp of 8 per sample, every 8 ms. The output is a ramp of 1 per cycle, one sample late.
  for (int i = 0; i < 50; ++i) {
    in.write(number(8.0 * i));
    for (int t = 0; t < 8; ++t) {
      module.step();
      ASSERT_NEAR(out.value().value(), i == 0 ? 0 : 8.0 * (i - 1) + t, 1e-9);
    }
  }
}

TEST(Resampler, RejectsAnUnknownMethod) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  const auto rejected = module.set("method", "cubic");
  ASSERT_FALSE(rejected.ok());
  EXPECT_EQ(rejected.text(), "property 'method' cannot be 'cubic'; it takes text, hold, linear or average");
}

TEST(Resampler, ChangesItsMethodWhileItRuns) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in", {.queue = 4});
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(1), microseconds{500});
  in.write(number(2));
  module.step();
  EXPECT_EQ(out.value().value(), 2);
  ASSERT_TRUE(module.set("method", "average"));
  in.write(number(5), microseconds{500});
  in.write(number(6));
  module.step();
  EXPECT_EQ(out.value().value(), 5.5);
}

TEST(Resampler, DiscardsItsSamplesAfterANonFiniteInput) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in", {.queue = 4});
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(std::nan("")));
  module.step();
  EXPECT_EQ(module.last_error().type, takt::ErrorType::failure);
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_FALSE(out.has_value());
}

}  // namespace
}  // namespace resampler
