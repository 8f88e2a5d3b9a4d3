#include <takt/os/trial.hpp>

#include <gmock/gmock.h>

#include <takt/os/machine.hpp>
#include <takt/os/real_time.hpp>

namespace takt::os::trial_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::ElementsAre;

TEST(WakeUpStatistics, AreZeroWithoutMeasurements) {
  EXPECT_EQ(wake_ups_of({}).count, 0U);
  EXPECT_EQ(wake_ups_of({}).max, Nanoseconds{0});
}

TEST(WakeUpStatistics, GiveEqualQuantilesForASingleDelay) {
  const WakeUps one = wake_ups_of({microseconds{7}});
  EXPECT_EQ(one.count, 1U);
  EXPECT_EQ(one.p50, microseconds{7});
  EXPECT_EQ(one.p99, microseconds{7});
  EXPECT_EQ(one.max, microseconds{7});
}

TEST(WakeUpStatistics, DoNotDependOnTheOrderOfTheDelays) {
  std::vector<Nanoseconds> delays;
  for (int i = 1000; i >= 0; --i) delays.push_back(microseconds{i});
  const WakeUps wake_ups = wake_ups_of(delays);
  EXPECT_EQ(wake_ups.p50, microseconds{500});
  EXPECT_EQ(wake_ups.p99, microseconds{990});
  EXPECT_EQ(wake_ups.max, microseconds{1000});
}

TEST(Trial, MeasuresNoNegativeDelay) {
  const WakeUps wake_ups = try_wake_ups(5, microseconds{200});
  EXPECT_EQ(wake_ups.count, 5U);
  EXPECT_GE(wake_ups.p50, Nanoseconds{0});
  EXPECT_LE(wake_ups.p50, wake_ups.max);
}

TEST(ExecutorCpus, AreTheIsolatedCpusThatArePermitted) {
  const model::Cpus cpus{.online = {0, 1, 2, 3}, .permitted = {0, 1, 2}, .ordinary = {0}};
  EXPECT_THAT(executor_cpus({1, 2, 3}, cpus), ElementsAre(1, 2));
}

TEST(ExecutorCpus, IsTheHighestOrdinaryCpuIfNoIsolatedCpuIsPermitted) {
  const model::Cpus cpus{.online = {0, 1, 2, 3}, .permitted = {0, 1, 2}, .ordinary = {0, 1}};
  EXPECT_THAT(executor_cpus({}, cpus), ElementsAre(1));
  EXPECT_THAT(executor_cpus({3}, cpus), ElementsAre(1));
}

TEST(Trial, RestoresTheSettingsOfTheCallingThread) {
  const bool real_time = is_real_time();
  const model::Cpus cpus = read_cpus();
  const Trial trial = try_machine(milliseconds{3});
  EXPECT_EQ(trial.wake_ups.count, 3U);
  EXPECT_GE(trial.timer_resolution, Nanoseconds{1});
  EXPECT_EQ(is_real_time(), real_time);
  EXPECT_EQ(read_cpus(), cpus);
}

}  // namespace
}  // namespace takt::os::trial_test
