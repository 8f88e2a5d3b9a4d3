#include <takt/client/history.hpp>

#include <cmath>

#include <gmock/gmock.h>

#include <takt/wire/words.hpp>

namespace takt::client::history_test {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::SizeIs;

constexpr std::int64_t kBegin_ms = 1'700'000'000'000;

ModuleStatistics servo(std::int64_t time_ms, std::uint64_t cycles = 0) {
  ModuleStatistics statistics;
  wire::set(statistics.name(), "servo");
  statistics.time_ns((kBegin_ms + time_ms) * 1'000'000);
  statistics.cycles(cycles);
  return statistics;
}

std::vector<wire::ObservedDevice> robot(const std::vector<ModuleStatistics>& modules) {
  wire::ObservedDevice device;
  wire::set(device.status.device(), "robot");
  for (const ModuleStatistics& each : modules) device.deployment.statistics[each.name().to_string()] = each;
  return {device};
}

TEST(History, IsEmptyForAnUnknownModule) {
  History history;
  EXPECT_THAT(history.of("robot.servo").times_ms, SizeIs(0));
  history.add({});
  history.add(robot({}));
  EXPECT_THAT(history.of("robot.servo").times_ms, SizeIs(0));
}

TEST(History, ReturnsTheNewestEntriesInChronologicalOrder) {
  History history;
  for (int i = 0; i < 3; ++i) {
    ModuleStatistics statistics = servo(i * 1000);
    statistics.jitter_us().p50(i + 0.5);
    statistics.jitter_us().p99(i + 10);
    statistics.run_us().p50(i + 20);
    statistics.run_us().p99(i + 30);
    history.add(robot({statistics}));
  }
  const Series series = history.of("robot.servo");
  EXPECT_THAT(series.times_ms, ElementsAre(kBegin_ms, kBegin_ms + 1000, kBegin_ms + 2000));
  EXPECT_THAT(series.jitter_p50_us, ElementsAre(0.5, 1.5, 2.5));
  EXPECT_THAT(series.jitter_p99_us, ElementsAre(10, 11, 12));
  EXPECT_THAT(series.run_p50_us, ElementsAre(20, 21, 22));
  EXPECT_THAT(series.run_p99_us, ElementsAre(30, 31, 32));
  EXPECT_THAT(history.of("robot.servo", 2).jitter_p99_us, ElementsAre(11, 12));
  EXPECT_THAT(history.of("robot.servo", 0).times_ms, SizeIs(0));
  EXPECT_THAT(history.of("line.servo").times_ms, SizeIs(0));
}

TEST(History, KeepsOneEntryPerSecondAndModule) {
  History history;
  for (int ms = 0; ms <= 3000; ms += 100) {
    history.add(robot({servo(ms)}));
    history.add(robot({servo(ms)}));
  }
  EXPECT_THAT(history.of("robot.servo").times_ms,
              ElementsAre(kBegin_ms, kBegin_ms + 900, kBegin_ms + 1800, kBegin_ms + 2700));
}

TEST(History, KeepsOnlyTheLastTenMinutes) {
  History history;
  for (std::int64_t i = 0; i < 1501; ++i) {
    ModuleStatistics statistics = servo(i * 1000);
    statistics.jitter_us().p99(static_cast<double>(i));
    history.add(robot({statistics}));
    const Series series = history.of("robot.servo");
    ASSERT_EQ(series.times_ms.size(), std::min<std::int64_t>(i + 1, 600));
    ASSERT_EQ(series.times_ms.back(), kBegin_ms + i * 1000);
    ASSERT_EQ(series.times_ms.front(), kBegin_ms + std::max<std::int64_t>(i - 599, 0) * 1000);
    ASSERT_EQ(series.jitter_p99_us.back(), static_cast<double>(i));
  }
  EXPECT_EQ(history.of("robot.servo", 60).jitter_p99_us.front(), 1441);
}

TEST(History, ComputesMeansForTheCyclesBetweenTwoSetsOfStatistics) {
  History history;
  // The first 1000 cycles have a jitter of -2 us. The jitter of the next 1000 alternates between -3 us and 5
  // us.
  ModuleStatistics statistics = servo(0, 1000);
  statistics.jitter_us().mean(-2);
  statistics.run_us().mean(10);
  history.add(robot({statistics}));
  statistics = servo(1000, 2000);
  statistics.jitter_us().mean(-0.5);  // the mean over all cycles: (-2 * 1000 + 1 * 1000) / 2000
  statistics.jitter_us().variance((4.0 + 17.0) / 2 - 0.25);
  statistics.run_us().mean(25);
  history.add(robot({statistics}));
  // The module is stopped for a second and then reloaded, so its counts start again from 0.
  statistics.time_ns(servo(2000).time_ns());
  history.add(robot({statistics}));
  statistics = servo(3000, 10);
  statistics.jitter_us().mean(7);
  statistics.run_us().mean(8);
  history.add(robot({statistics}));

  const Series series = history.of("robot.servo");
  ASSERT_THAT(series.jitter_us, SizeIs(4));
  EXPECT_TRUE(std::isnan(series.jitter_us[0])) << "there is no previous entry";
  EXPECT_THAT(series.jitter_us[1], DoubleNear(std::sqrt(17), 1e-5));
  EXPECT_TRUE(std::isnan(series.jitter_us[2])) << "the module did not run";
  EXPECT_THAT(series.jitter_us[3], DoubleNear(7, 1e-5));
  EXPECT_TRUE(std::isnan(series.run_us[0]));
  EXPECT_THAT(series.run_us[1], DoubleNear(40, 1e-5));
  EXPECT_TRUE(std::isnan(series.run_us[2]));
  EXPECT_THAT(series.run_us[3], DoubleNear(8, 1e-5));
}

TEST(History, StartsAgainWhenTheClockOfTheDeviceIsSetBack) {
  History history;
  for (const std::int64_t ms : {0, 1000, 2000, -500'000, -499'000}) history.add(robot({servo(ms)}));
  EXPECT_THAT(history.of("robot.servo").times_ms, ElementsAre(kBegin_ms - 500'000, kBegin_ms - 499'000));
}

TEST(History, ForgetsAModuleThatHasDisappeared) {
  History history;
  history.add(robot({servo(0)}));
  history.add(robot({}));
  EXPECT_THAT(history.of("robot.servo").times_ms, SizeIs(0));
}

TEST(History, IgnoresFurtherModulesAboveItsLimit) {
  std::vector<ModuleStatistics> modules;
  for (std::size_t i = 0; i <= History::kModules; ++i) {
    modules.push_back(servo(0));
    wire::set(modules.back().name(), "m" + std::to_string(100'000 + i));
  }
  History history;
  history.add(robot(modules));
  EXPECT_THAT(history.of("robot.m100000").times_ms, SizeIs(1));
  EXPECT_THAT(history.of("robot.m109999").times_ms, SizeIs(1));
  EXPECT_THAT(history.of("robot.m110000").times_ms, SizeIs(0));
}

}  // namespace
}  // namespace takt::client::history_test
