#include <takt/component.hpp>

#include <cstring>
#include <stdexcept>
#include <string>
#include <thread>

#include <takt/module.h>
#include <takt/component/current_cycle.hpp>
#include <takt/component/failure.hpp>

#include <gtest/gtest.h>

class Ramp : public takt::Component {
 public:
  ~Ramp() override { ++ended; }
  void run(const takt::Cycle& cycle) noexcept override {
    value += slope * cycle.seconds();
    if (value > 2) fail("above 2");
  }
  takt::Property<double> slope{*this, "slope", 1.0};
  double value = 0;
  static inline int ended = 0;
};
TAKT_COMPONENT(Ramp)

namespace takt::component_test {
namespace {

using namespace std::chrono_literals;

TEST(Factory, CreatesAndDestroysTheComponent) {
  const ComponentFactory* factory = takt_component_factory();
  ASSERT_NE(factory, nullptr);
  EXPECT_EQ(factory->abi, ComponentFactory::kAbi);
  EXPECT_EQ(factory->component_size, sizeof(Component));
  EXPECT_STREQ(factory->name, "Ramp");
  Component* component = factory->create();
  EXPECT_EQ(component->properties().size(), 1u);
  factory->destroy(component);
  EXPECT_EQ(Ramp::ended, 1);
}

TEST(Factory, CreatesASeparateObjectForEachModule) {
  const ComponentFactory* factory = takt_component_factory();
  Component* first = factory->create();
  Component* second = factory->create();
  ASSERT_TRUE(first->properties()[0]->assign("5").ok());
  EXPECT_EQ(second->properties()[0]->value_text(), "1");
  factory->destroy(first);
  factory->destroy(second);
}

TEST(Component, ReceivesThePeriodOfItsCycle) {
  Ramp ramp;
  for (std::uint64_t n = 0; n < 10; ++n) ramp.run({.number = n, .time = {}, .period = 100ms});
  EXPECT_NEAR(ramp.value, 1, 1e-12);
}

TEST(Component, SucceedsInHooksThatItDoesNotOverride) {
  Ramp ramp;
  EXPECT_TRUE(ramp.initialize().ok());
  EXPECT_TRUE(ramp.start().ok());
  EXPECT_TRUE(ramp.recover().ok());
  EXPECT_FALSE(ramp.condition());
  ramp.error(ErrorType::budget);
  ramp.destruct();
}

TEST(Failure, IsReturnedOnceAfterAComponentReportsIt) {
  Ramp ramp;
  EXPECT_EQ(take_failure(), nullptr);
  ramp.run({.number = 0, .time = {}, .period = 3s});
  EXPECT_STREQ(take_failure(), "above 2");
  EXPECT_EQ(take_failure(), nullptr);
}

TEST(Failure, CanBeReportedByAComponentInC) {
  takt_fail("no sensor");
  EXPECT_STREQ(take_failure(), "no sensor");
}

TEST(Failure, CanBeReportedWithoutAReason) {
  takt_fail(nullptr);
  EXPECT_STREQ(take_failure(), "no reason given");
  takt_fail("");
  EXPECT_STREQ(take_failure(), "no reason given");
}

TEST(Failure, ReplacesAnEarlierFailureThatWasNotRead) {
  report_failure("first");
  report_failure("second");
  EXPECT_STREQ(take_failure(), "second");
}

TEST(Failure, ShortensAReasonThatIsTooLong) {
  const std::string fits(kFailureText - 1, 'x');
  report_failure(fits);
  EXPECT_EQ(take_failure(), fits);
  report_failure(fits + "y");
  EXPECT_EQ(take_failure(), fits);
}

TEST(Failure, IsReturnedOnlyOnTheThreadThatReportedIt) {
  std::thread([] { report_failure("of another thread"); }).join();
  EXPECT_EQ(take_failure(), nullptr);
}

TEST(CurrentCycle, IsZeroWhileNoHookOfTheModuleRuns) {
  EXPECT_EQ(takt_period_ns(), 0);
  const Cycle cycle{.number = 7, .time = from_ns(5'000), .period = Nanoseconds{600'000}};
  serve_cycle(&cycle);
  EXPECT_EQ(takt_cycle(), 7U);
  EXPECT_EQ(takt_release_ns(), 5'000);
  EXPECT_EQ(takt_period_ns(), 600'000);
  std::thread([] { EXPECT_EQ(takt_cycle(), 0U); }).join();
  serve_cycle(nullptr);
  EXPECT_EQ(takt_cycle(), 0U);
}

TEST(ErrorType, UsesTheSameNumbersAsTheCInterface) {
  EXPECT_EQ(static_cast<int>(ErrorType::failure), TAKT_ERROR_FAILURE);
  EXPECT_EQ(static_cast<int>(ErrorType::budget), TAKT_ERROR_BUDGET);
  EXPECT_EQ(static_cast<int>(ErrorType::start), TAKT_ERROR_START);
  EXPECT_EQ(static_cast<int>(ErrorType::crash), TAKT_ERROR_CRASH);
  EXPECT_EQ(static_cast<int>(ErrorType::hang), TAKT_ERROR_HANG);
  EXPECT_EQ(static_cast<int>(ErrorType::deadline), TAKT_ERROR_DEADLINE);
  EXPECT_EQ(static_cast<int>(ErrorType::stale), TAKT_ERROR_STALE);
  EXPECT_EQ(static_cast<int>(ErrorType::overrun), TAKT_ERROR_OVERRUN);
}

}  // namespace
}  // namespace takt::component_test
