#include "notch_filter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"
#include "../common/frequency_response.hpp"

namespace notch {
namespace {

using common::number;
using std::chrono::milliseconds;

std::complex<double> response_at(int cycles, double frequency, double width, double period = 1e-3) {
  NotchFilter filter;
  filter.design(frequency, width, period);
  return common::frequency_response([&](double x) { return filter.step(x); }, cycles, 1000, 20000);
}

TEST(NotchFilter, RemovesItsFrequency) {
  for (const int frequency : {3, 50, 123, 250, 400, 480})
    EXPECT_LT(std::abs(response_at(frequency, frequency, 5)), 1e-9) << frequency;
}

TEST(NotchFilter, MatchesTheTheoreticalResponse) {
  for (const double frequency : {20.0, 110.0, 333.0}) {
    for (const double width : {4.0, 40.0, 200.0}) {
      for (const int cycles : {1, 19, 50, 100, 333, 499}) {
        const double t0 = std::tan(std::numbers::pi * frequency / 1000);
        const double w = std::tan(std::numbers::pi * cycles / 1000) / t0;
        const double damping = std::tan(std::numbers::pi * width / 1000) * (1 + t0 * t0) / t0;
        const std::complex<double> expected = (1 - w * w) / std::complex<double>(1 - w * w, damping * w);
        ASSERT_NEAR(std::abs(response_at(cycles, frequency, width) - expected), 0, 1e-9)
            << frequency << " " << width << " " << cycles;
      }
    }
  }
}

TEST(NotchFilter, HasItsExactWidthInTheSampledSignal) {
  // With 1000 steps per second, frequencies are whole hertz. The loops search for the half-power frequencies
  // on both sides.
  for (const int frequency : {100, 250, 400}) {
    constexpr int kWidth = 60;
    double low = 0;
    double high = 0;
    for (int cycles = 1; cycles < 500; ++cycles) {
      const double power = std::norm(response_at(cycles, frequency, kWidth));
      if (cycles < frequency && power >= 0.5) low = cycles;
      if (cycles > frequency && power >= 0.5 && high == 0) high = cycles;
    }
    EXPECT_NEAR(high - low, kWidth, 2) << frequency;  // both edges are rounded outwards, to whole Hz
  }
}

TEST(NotchFilter, PassesAConstantUnchanged) {
  NotchFilter filter;
  filter.design(50, 10, 1e-3);
  for (int i = 0; i < 1000; ++i) EXPECT_NEAR(filter.step(-3), -3, 1e-12);
}

TEST(NotchFilter, ChangesItsFrequencyAndWidthWithoutAJump) {
  NotchFilter filter;
  filter.design(50, 10, 1e-3);
  double last = filter.step(0);
  for (int i = 1; i < 10000; ++i) {
    if (i % 50 == 0) filter.design(40 + i % 70, 5 + i % 11, 1e-3);
    const double now = filter.step(std::sin(i * 1e-3));
    ASSERT_LT(std::abs(now - last), 0.01) << i;
    last = now;
  }
}

TEST(Notch, FiltersItsInputWithTheGivenProperties) {
  takt::testing::Module module{{.period = milliseconds{2}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.set("frequency", "60"));
  ASSERT_TRUE(module.set("width", "7"));
  ASSERT_TRUE(module.start());
  NotchFilter filter;
  filter.design(60, 7, 2e-3);
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  for (int i = 0; i < 3000; ++i) {
    const double value = noise(random);
    in.write(number(value));
    module.step();
    ASSERT_DOUBLE_EQ(out.value().value(), filter.step(value)) << i;
  }
}

TEST(Notch, RejectsAFrequencyTooHighForItsPeriod) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  const auto start = module.start();  // with the default frequency, 50 Hz
  ASSERT_FALSE(start.ok());
  EXPECT_EQ(
      start.text(),
      "property 'frequency' cannot be '50'; it takes a number, 1e-04 to 49 at a period of 10 ms, in Hz");
}

TEST(Notch, GoesToRecoverIfItsInputIsNotFinite) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& in = module.in<basic::Number>("in");
  ASSERT_TRUE(module.start());
  in.write(number(std::nan("")));
  module.step();
  EXPECT_EQ(module.last_error().type, takt::ErrorType::failure);
}

}  // namespace
}  // namespace notch
