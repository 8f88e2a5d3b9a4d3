#include "waveform.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace signal_generator {
namespace {

using std::chrono::milliseconds;

TEST(Waveform, FollowsTheFormulaOfEachShape) {
  for (int i = 0; i < 1000; ++i) {
    const double phase = i / 1000.0;
    EXPECT_NEAR(shape_at(Shape::sine, phase), std::sin(2 * std::numbers::pi * phase), 1e-12);
    EXPECT_EQ(shape_at(Shape::square, phase), i < 500 ? 1 : -1);
    EXPECT_NEAR(shape_at(Shape::triangle, phase),
                2 / std::numbers::pi * std::asin(std::sin(2 * std::numbers::pi * phase)), 1e-7);
    EXPECT_NEAR(shape_at(Shape::sawtooth, phase), 2 * (phase - std::round(phase)), 1e-9);
  }
}

TEST(SignalGenerator, KeepsItsPhaseOverAMillionCyclesAndMissedReleases) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& out = module.out<basic::Number>("out");
  auto& flag = module.out<basic::Flag>("flag");
  ASSERT_TRUE(module.set("frequency", "4"));
  ASSERT_TRUE(module.set("amplitude", "3"));
  ASSERT_TRUE(module.set("offset", "1"));
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_EQ(out.value().value(), 1);
  module.miss(62);
  module.step();  // release 63 is at 0.252 of a signal period
  EXPECT_NEAR(out.value().value(), 1 + 3 * std::sin(2 * std::numbers::pi * 0.252), 1e-9);
  EXPECT_TRUE(flag.value().value());
  module.step(1'000'000);
  EXPECT_NEAR(out.value().value(), 1 + 3 * std::sin(2 * std::numbers::pi * 0.252), 1e-6);
}

TEST(SignalGenerator, RepeatsTheSameValuesInEachSignalPeriod) {
  for (const char* shape : {"sine", "square", "triangle", "sawtooth"}) {
    takt::testing::Module module{{.period = milliseconds{1}}};
    auto& out = module.out<basic::Number>("out");
    auto& flag = module.out<basic::Flag>("flag");
    ASSERT_TRUE(module.set("shape", shape));
    ASSERT_TRUE(module.set("frequency", "7.8125"));  // a period of 128 cycles; exact in binary
    ASSERT_TRUE(module.start());
    module.step(128);
    const auto first = out.values();
    ASSERT_EQ(first.size(), 128U);
    EXPECT_FALSE(flag.value().value()) << shape;
    module.step(20 * 128);
    for (std::size_t i = 0; i < out.values().size(); ++i)
      ASSERT_NEAR(out.values()[i].value(), first[i % 128].value(), 1e-9) << shape << ", cycle " << 128 + i;
    EXPECT_FALSE(flag.value().value()) << shape;
    module.step();
    EXPECT_TRUE(flag.value().value()) << shape;
  }
}

TEST(SignalGenerator, StaysContinuousWhenTheFrequencyChanges) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  double last = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i % 100 == 0) {
      ASSERT_TRUE(module.set("frequency", std::to_string(1 + i / 100 % 5)));
    }
    module.step();
    ASSERT_LT(std::abs(out.value().value() - last), 2 * std::numbers::pi * 5 * 1e-3 + 1e-9);
    last = out.value().value();
  }
}

TEST(SignalGenerator, RejectsAFrequencyAboveHalfTheSamplingRate) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  ASSERT_TRUE(module.set("frequency", "51"));
  EXPECT_EQ(module.start().text(),
            "property 'frequency' cannot be '51'; it takes a number, 0 to 50 at a period of 10 ms, in Hz");
}

}  // namespace
}  // namespace signal_generator
