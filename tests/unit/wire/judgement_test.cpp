#include <takt/wire/judgement.hpp>

#include <gtest/gtest.h>

namespace takt::wire::judgement_test {
namespace {

using namespace std::chrono_literals;

Rating rating(const ConnectionReport& connection) { return judge(connection).rating; }
std::string reason(const ConnectionReport& connection) { return judge(connection).reason(); }

TEST(ConnectionJudgement, IsGoodForAFreshValue) {
  EXPECT_EQ(rating({.age = 1ms, .deadline = 20ms}), Rating::good);
  EXPECT_EQ(reason({.age = 1ms, .deadline = 20ms}), "ok");
}

TEST(ConnectionJudgement, IsPoorOnlyWhileSamplesAreBeingDroppedOrLost) {
  EXPECT_EQ(rating({.age = 1ms, .dropping = true, .dropped = 27757}), Rating::poor);
  EXPECT_EQ(reason({.age = 1ms, .dropping = true, .dropped = 27757}), "degraded: drops samples");
  EXPECT_EQ(reason({.age = 1ms, .losing = true}), "degraded: loses samples");
  EXPECT_EQ(reason({.age = 1ms, .losing = true, .dropping = true}), "degraded: loses and drops samples");
  EXPECT_EQ(rating({.age = 1ms, .lost = 3, .dropped = 27757}), Rating::good) << "that was long ago";
}

TEST(ConnectionJudgement, IsGoodAgainAsSoonAsALateValueHasArrived) {
  EXPECT_EQ(reason({.age = 21ms, .deadline = 20ms, .late = 4}), "stale");
  EXPECT_EQ(rating({.age = 1ms, .deadline = 20ms, .late = 4}), Rating::good);
}

TEST(ConnectionJudgement, IsGoodForAnEventThatHasNeverHappened) {
  EXPECT_EQ(rating({}), Rating::good);
  EXPECT_EQ(reason({}), "ok: no value yet");
  EXPECT_EQ(rating({.safe = true}), Rating::good) << "the reader has had no other value yet";
  EXPECT_EQ(rating({.deadline = 20ms}), Rating::bad) << "the reader needs a value";
  EXPECT_EQ(reason({.output = true}), "ok") << "an output has no value to wait for";
}

TEST(ConnectionJudgement, IsGoodIfNoOtherProgramUsesATopic) {
  EXPECT_EQ(rating({.matched = false, .outside = true, .output = true}), Rating::good);
  EXPECT_EQ(reason({.matched = false, .outside = true, .output = true}), "no other program reads it");
  EXPECT_EQ(reason({.matched = false, .outside = true}), "no other program writes it");
  EXPECT_EQ(reason({.matched = false, .outside = true, .deadline = 20ms}), "stale");
}

TEST(ConnectionJudgement, IsPoorWhileTheInputIsForcedWhateverArrives) {
  for (const ConnectionReport& report :
       {ConnectionReport{.age = 1ms, .forced = "operator anna"},
        ConnectionReport{
            .matched = false, .deadline = 1ms, .incompatible = "x", .forced = "operator anna"}}) {
    EXPECT_EQ(rating(report), Rating::poor);
    EXPECT_EQ(reason(report), "forced: by operator anna");
  }
  EXPECT_EQ(judge(ModuleReport{.state = "EXECUTING", .forced = true}), Rating::poor);
}

TEST(ConnectionJudgement, IsBrokenIfBothEndsBelongToTheCellButOnlyOneIsThere) {
  EXPECT_EQ(rating({.matched = false, .age = 1ms}), Rating::broken);
  EXPECT_EQ(reason({.matched = false}), "not matched");
  EXPECT_EQ(reason({.outside = true, .incompatible = "reliability"}), "not matched: reliability");
}

TEST(ConnectionJudgement, NamesTheWorstTroubleFirst) {
  const ConnectionReport all{
      .safe = true, .age = 30ms, .deadline = 20ms, .dropping = true, .incompatible = "reliability"};
  ConnectionReport one = all;
  EXPECT_EQ(rating(one), Rating::broken);
  one.incompatible.clear();
  EXPECT_EQ(reason(one), "safe value");
  EXPECT_EQ(rating(one), Rating::bad);
  one.safe = false;
  EXPECT_EQ(reason(one), "stale");
  one.age = 1ms;
  EXPECT_EQ(rating(one), Rating::poor);
}

TEST(ModuleJudgement, IsBadOnlyIfTheModuleFailedOrItsDeviceIsLost) {
  EXPECT_EQ(judge(ModuleReport{.state = "EXECUTING"}), Rating::good);
  EXPECT_EQ(judge(ModuleReport{.state = "EXECUTING", .safe_stop = true}), Rating::poor);
  EXPECT_EQ(judge(ModuleReport{.state = "EXECUTING", .lost = true}), Rating::bad);
  EXPECT_EQ(judge(ModuleReport{.state = "RECOVER"}), Rating::bad);
  EXPECT_EQ(judge(ModuleReport{.state = "DESTRUCT", .given_up = true}), Rating::bad);
  EXPECT_EQ(judge(ModuleReport{.state = "DESTRUCT"}), Rating::idle) << "it has finished, or was ended";
  for (const char* state : {"IDLE", "INITIALIZE", "START"})
    EXPECT_EQ(judge(ModuleReport{.state = state}), Rating::idle) << state;
}

TEST(DeviceJudgement, FollowsTheHealthThatTheDeviceReports) {
  EXPECT_EQ(judge(DeviceReport{.state = "running", .health = "ok"}), Rating::good);
  EXPECT_EQ(judge(DeviceReport{.state = "running", .health = "degraded"}), Rating::poor);
  EXPECT_EQ(judge(DeviceReport{.state = "running", .health = "failed"}), Rating::bad);
  EXPECT_EQ(judge(DeviceReport{.state = "running", .health = "ok", .alive = false}), Rating::bad);
  EXPECT_EQ(judge(DeviceReport{.state = "waiting", .health = "ok"}), Rating::idle);
}

TEST(RisingCount, BeginsToRiseOnceAndEndsSomeTimeAfterTheLastRise) {
  RisingCount count;
  EXPECT_FALSE(count.update(27757, 1s)) << "it may have risen long ago";
  EXPECT_FALSE(count.rises(1s));
  EXPECT_TRUE(count.update(27758, 2s));
  EXPECT_TRUE(count.rises(2s));
  EXPECT_FALSE(count.update(27759, 6s)) << "it still rises";
  EXPECT_FALSE(count.update(27759, 10s));
  EXPECT_TRUE(count.rises(10s));
  EXPECT_FALSE(count.update(27759, 11s));
  EXPECT_FALSE(count.rises(11s)) << "5 s after the last rise";
  EXPECT_TRUE(count.update(27760, 12s)) << "it begins again";
}

TEST(RisingCount, CountsFromTheValueThatItBeginsWith) {
  EXPECT_TRUE(RisingCount{0}.update(3, 1s));
  EXPECT_FALSE(RisingCount{0}.update(0, 1s));
}

TEST(RisingCount, BeginsAgainWithTheCounterOfANewDeployment) {
  RisingCount count;
  count.update(100, 1s);
  EXPECT_FALSE(count.update(7, 2s));
  EXPECT_TRUE(count.update(8, 3s));
}

TEST(RisingCount, EndsAlsoIfTheClockIsSetBack) {
  RisingCount count{0};
  EXPECT_TRUE(count.update(1, 1h));
  EXPECT_TRUE(count.rises(1h - 1s));
  EXPECT_FALSE(count.rises(1s));
}

}  // namespace
}  // namespace takt::wire::judgement_test
