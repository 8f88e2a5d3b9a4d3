// Tests @name@ on virtual time, without a cell. <takt/testing.hpp> describes what a test can do.
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <@name@_types.hpp>

namespace {

const takt::testing::Options kOptions{.period = std::chrono::milliseconds{1}, .sporadic = @sporadic@};

@name@_types::Sample value(double number) {
  @name@_types::Sample value;
  value.value(number);
  return value;
}

TEST(@Name@, MultipliesTheInput) {
  takt::testing::Module module{kOptions};
  ASSERT_TRUE(module.set("gain", "3"));
  auto& in = module.in<@name@_types::Sample>("in");
  auto& out = module.out<@name@_types::Sample>("out");
  ASSERT_TRUE(module.start());
  in.write(value(2));
  module.step();
  ASSERT_EQ(out.count(), 1U);
  EXPECT_EQ(out.value().value(), 6);
}

TEST(@Name@, WritesNothingWithoutInput) {
  takt::testing::Module module{kOptions};
  auto& out = module.out<@name@_types::Sample>("out");
  ASSERT_TRUE(module.start());
  module.step(1000);
  EXPECT_EQ(out.count(), 0U);
}

TEST(@Name@, RejectsAGainThatIsNotANumber) {
  takt::testing::Module module{kOptions};
  EXPECT_FALSE(module.set("gain", "much") && module.start());
}

}  // namespace
