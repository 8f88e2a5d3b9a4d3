#include "first_order.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace process_model {
namespace {

using common::number;
using std::chrono::milliseconds;

TEST(FirstOrder, FollowsTheTheoreticalStepResponseForAnyPeriod) {
  for (const double dt : {1e-4, 0.01, 5.0}) {
    for (const std::size_t delay : {std::size_t{0}, std::size_t{7}, FirstOrder::kMostDelay}) {
      const auto process = std::make_unique<FirstOrder>();
      for (std::size_t i = 0; i < delay + 200; ++i) {
        const double output = process->step(1, 3, 2, delay, dt);
        const double since = i < delay ? 0 : static_cast<double>(i - delay + 1) * dt;
        ASSERT_NEAR(output, 3 * (1 - std::exp(-since / 2)), 1e-9) << dt << " " << delay << " " << i;
      }
    }
  }
}

TEST(ProcessModel, RejectsADeadTimeAbove4096Periods) {
  takt::testing::Module module{{.period = milliseconds{1}}};
  ASSERT_TRUE(module.set("dead_time", "5"));
  EXPECT_EQ(module.start().text(),
            "property 'dead_time' cannot be '5'; it takes a number, 0 to 4.096 at a period of 1 ms, in s");
}

TEST(ProcessModel, StaysAtZeroUntilItsFirstInput) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  module.step(10);
  EXPECT_EQ(out.value().value(), 0);
  in.write(number(2));
  module.step(100);
  EXPECT_NEAR(out.value().value(), 2 * (1 - std::exp(-1)), 1e-9);
}

TEST(ProcessModel, GoesToRecoverIfItsInputIsNotFinite) {
  takt::testing::Module module;
  auto& in = module.in<basic::Number>("in");
  ASSERT_TRUE(module.start());
  in.write(number(std::numeric_limits<double>::quiet_NaN()));
  module.step();
  EXPECT_EQ(module.last_error().text, "the input is not a finite number");
}

}  // namespace
}  // namespace process_model
