#include <takt/model/cell.hpp>

#include <gtest/gtest.h>

namespace takt::model::hang_limit_test {
namespace {

using namespace std::chrono_literals;

Module every(Nanoseconds period) {
  Module module;
  module.period = period;
  return module;
}

TEST(HangLimit, IsOneSecondPlusTenPeriodsIfTheModuleHasNoBudget) {
  EXPECT_EQ(hang_limit(every(1ms)), 1010ms);
  EXPECT_EQ(hang_limit(every(10s)), 61s);
  EXPECT_EQ(hang_limit(every(Nanoseconds::max())), 61s);
  Module sporadic;
  sporadic.deadline = 5ms;
  EXPECT_EQ(hang_limit(sporadic), 1050ms);
  EXPECT_EQ(hang_limit(Module{}), 1s);
}

TEST(HangLimit, IsTenTimesTheBudgetOfAThreadModuleButAtLeast20Ms) {
  Module module = every(1s);
  module.budget = 300us;
  EXPECT_EQ(hang_limit(module), 20ms);
  module.budget = 30ms;
  EXPECT_EQ(hang_limit(module), 300ms);
  module.tolerance.times = 3;
  EXPECT_EQ(hang_limit(module), 300ms);
  module.tolerance.times = 50;
  EXPECT_EQ(hang_limit(module), 1500ms);
  module.budget = Nanoseconds::max();
  EXPECT_EQ(hang_limit(module), 50h);
  module.type = ModuleType::process;
  EXPECT_EQ(hang_limit(module), 11s) << "the budget of a process module is only used for proofs";
}

TEST(HangLimit, IsTheTimeThatTheDescriptorGives) {
  Module module = every(1ms);
  module.budget = 300us;
  module.hang = 7ms;
  for (const ModuleType type : {ModuleType::thread, ModuleType::process}) {
    module.type = type;
    EXPECT_EQ(hang_limit(module), 7ms);
  }
}

}  // namespace
}  // namespace takt::model::hang_limit_test
