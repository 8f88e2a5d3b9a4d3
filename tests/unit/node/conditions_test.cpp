#include "conditions.hpp"

#include <gmock/gmock.h>

namespace takt::node::conditions_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const os::Throttling kOld{.kept = milliseconds{50}};
const os::Throttling kServer{.kept = milliseconds{50}, .fair_server = true};

model::Device device(model::Wakeup wakeup, Nanoseconds period) {
  model::Device device;
  device.executors.emplace_back();
  device.executors[0].wakeup = wakeup;
  model::Module& module = device.modules.emplace_back();
  module.name = "m";
  module.type = model::ModuleType::thread;
  module.operation = model::Operation::periodic;
  module.period = period;
  module.executor = "main";
  return device;
}

std::vector<std::string> warnings(const model::Device& of, const Conditions& conditions) {
  return warnings_for(of, *schedule::plan(model::Cell{}, of), conditions);
}

TEST(ConditionsCheck, GivesNoWarningIfAllConditionsAreGood) {
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, milliseconds{1}), {}), IsEmpty());
  EXPECT_THAT(warnings(device(model::Wakeup::spin, milliseconds{1}), {}), IsEmpty());
}

TEST(ConditionsCheck, WarnsThatASpinningExecutorWillBeThrottled) {
  const auto spins = device(model::Wakeup::spin, milliseconds{1});
  EXPECT_THAT(warnings(spins, {.throttling = kOld}),
              ElementsAre(AllOf(HasSubstr("executor main never sleeps"), HasSubstr("50 ms of each second"),
                                HasSubstr("sched_rt_runtime_us=-1"))));
  EXPECT_THAT(warnings(spins, {.throttling = kServer}), ElementsAre(HasSubstr("fair_server")));
  EXPECT_THAT(warnings(spins, {.throttling = os::Throttling{}}), IsEmpty());
  EXPECT_THAT(warnings(spins, {.throttling = kOld, .prioritised = false}), IsEmpty())
      << "only real-time threads are throttled";
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, milliseconds{1}), {.throttling = kOld}), IsEmpty());
}

TEST(ConditionsCheck, WarnsIfTheTimerResolutionIsNotFinerThanThePeriod) {
  const Conditions ticks{.timer_resolution = milliseconds{4}};
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, milliseconds{4}), ticks),
              ElementsAre(HasSubstr("no high resolution")));
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, milliseconds{5}), ticks), IsEmpty());
  EXPECT_THAT(warnings(device(model::Wakeup::spin, milliseconds{1}), ticks), IsEmpty());
}

TEST(ConditionsCheck, WarnsIfTheBasicPeriodIsBelowOneMicrosecond) {
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, Nanoseconds{1}), {}),
              ElementsAre(AllOf(HasSubstr("basic period of 1 ns"), HasSubstr("in common"))));
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, microseconds{1}), {}), IsEmpty());
}

TEST(ConditionsCheck, WarnsIfWakeUpsAreTooLateForThePeriod) {
  const auto woken = [](Nanoseconds late) { return Conditions{.wake_ups = {20, late, late * 2, late * 2}}; };
  const auto hybrid = [](Nanoseconds period) { return device(model::Wakeup::hybrid, period); };
  EXPECT_THAT(warnings(hybrid(microseconds{100}), woken(microseconds{51})),
              ElementsAre(AllOf(HasSubstr("51 us late when the node started (median of 20 tries)"),
                                HasSubstr("period of 100 us"), HasSubstr("takt doctor"))));
  EXPECT_THAT(warnings(hybrid(microseconds{100}), woken(microseconds{50})), IsEmpty());
  EXPECT_THAT(warnings(device(model::Wakeup::sleep, microseconds{80}), woken(microseconds{41})),
              ElementsAre(HasSubstr("41 us late")));
  EXPECT_THAT(warnings(device(model::Wakeup::spin, microseconds{50}), woken(microseconds{51})), IsEmpty());
}

TEST(ConditionsCheck, DoesNotWarnOfLateWakeUpsThatALongPeriodTolerates) {
  const Conditions slow{.wake_ups = {20, microseconds{200}, microseconds{400}, microseconds{400}}};
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, milliseconds{1}), slow), IsEmpty());
  EXPECT_THAT(warnings(device(model::Wakeup::hybrid, milliseconds{100}), slow), IsEmpty());
}

TEST(ConditionsCheck, WarnsOfSwapIfMemoryIsNotLocked) {
  const auto any = device(model::Wakeup::hybrid, milliseconds{1});
  EXPECT_THAT(warnings(any, {.memory_locked = false, .swap_bytes = 1}), ElementsAre(HasSubstr("swapoff")));
  EXPECT_THAT(warnings(any, {.memory_locked = true, .swap_bytes = 1}), IsEmpty());
  EXPECT_THAT(warnings(any, {.memory_locked = false, .swap_bytes = 0}), IsEmpty());
}

TEST(ThrottledExecutor, IsDetectedByAGapOfAboutTheThrottledTime) {
  model::Executor spins;
  spins.wakeup = model::Wakeup::spin;
  EXPECT_FALSE(throttled(spins, milliseconds{1}, kOld).has_value());
  EXPECT_FALSE(throttled(spins, milliseconds{44}, kOld).has_value());
  EXPECT_TRUE(throttled(spins, milliseconds{45}, kOld).has_value());
  EXPECT_TRUE(throttled(spins, milliseconds{54}, kOld).has_value());
  EXPECT_TRUE(throttled(spins, milliseconds{75}, kOld).has_value());
  EXPECT_FALSE(throttled(spins, milliseconds{76}, kOld).has_value());
  EXPECT_FALSE(throttled(spins, milliseconds{50}, os::Throttling{}).has_value());
  EXPECT_FALSE(throttled(spins, Nanoseconds{0}, os::Throttling{}).has_value());
}

TEST(ThrottledExecutor, IsReportedByNameWithARemedy) {
  model::Executor executor;
  executor.name = "motion";
  executor.wakeup = model::Wakeup::spin;
  EXPECT_THAT(*throttled(executor, microseconds{53'987}, kServer),
              AllOf(HasSubstr("executor motion"), HasSubstr("53.9 ms"), HasSubstr("hybrid"),
                    HasSubstr("fair_server")));
  executor.wakeup = model::Wakeup::hybrid;
  EXPECT_THAT(*throttled(executor, milliseconds{50}, kOld),
              AllOf(HasSubstr("possibly because"), Not(HasSubstr("hybrid")), HasSubstr("takt doctor")));
}

}  // namespace
}  // namespace takt::node::conditions_test
