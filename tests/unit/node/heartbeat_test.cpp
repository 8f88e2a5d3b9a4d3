#include "heartbeat.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include <takt/wire/words.hpp>

namespace takt::node::heartbeat_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

class FakeSink final : public DeviceSink {
 public:
  void write(const DeviceStatus& status) override {
    written.push_back(status.path().to_string());
    last = status;
  }
  void dispose(const DeviceStatus& key) override { written.push_back("no " + key.path().to_string()); }

  std::vector<std::string> written;
  DeviceStatus last;
};

DeviceStatus status(const std::string& path) {
  DeviceStatus s;
  wire::set(s.path(), path);
  return s;
}

constexpr Instant kStart = from_ns(1'000'000'000);

TEST(Heartbeat, PublishesNothingBeforeItHasAStatus) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.beat(sink, kStart, 1);
  heartbeat.leave(sink);
  EXPECT_TRUE(sink.written.empty());
}

TEST(Heartbeat, RepeatsTheStatusWithANewSequenceNumberAndTime) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.kick(kStart);
  heartbeat.set(status("-/robot"));
  heartbeat.beat(sink, kStart, 10);
  heartbeat.beat(sink, kStart + milliseconds{100}, 20);
  EXPECT_THAT(sink.written, ElementsAre("-/robot", "-/robot"));
  EXPECT_EQ(sink.last.sequence_number(), 2U);
  EXPECT_EQ(sink.last.time_ns(), 20);
}

TEST(Heartbeat, AnswersTheNewestStatusOfEachNodeOnce) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.set(status("-/robot"));
  heartbeat.heard("a", 70, kStart);
  heartbeat.heard("b", 7, kStart + milliseconds{1});
  heartbeat.heard("a", 80, kStart + milliseconds{2});
  heartbeat.beat(sink, kStart + milliseconds{5}, 1);
  ASSERT_EQ(sink.last.echoes().size(), 2U);
  EXPECT_EQ(sink.last.monotonic_ns(), to_ns(kStart + milliseconds{5}));
  EXPECT_EQ(sink.last.echoes()[0].node(), "a");
  EXPECT_EQ(sink.last.echoes()[0].monotonic_ns(), 80);
  EXPECT_EQ(sink.last.echoes()[0].held_ns(), 3'000'000);
  EXPECT_EQ(sink.last.echoes()[1].held_ns(), 4'000'000);
  heartbeat.beat(sink, kStart + milliseconds{6}, 2);
  EXPECT_EQ(sink.last.echoes().size(), 0U);
}

TEST(Heartbeat, AnswersManyNodesInTurn) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.set(status("-/robot"));
  std::vector<std::string> answered;
  for (int beats = 0; beats < 5; ++beats) {
    for (int node = 0; node < 20; ++node) heartbeat.heard(std::to_string(node), beats, kStart);
    heartbeat.beat(sink, kStart, 1);
    ASSERT_EQ(sink.last.echoes().size(), Heartbeat::kAnswered);
    for (const StatusEcho& echo : sink.last.echoes()) answered.push_back(echo.node().to_string());
  }
  std::sort(answered.begin(), answered.end());
  EXPECT_EQ(std::unique(answered.begin(), answered.end()) - answered.begin(), 20);
}

TEST(Heartbeat, DisposesTheOldKeyOnlyAfterPublishingTheNewKey) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.set(status("-/robot"));
  heartbeat.beat(sink, kStart, 1);
  heartbeat.set(status("cell/robot"));
  heartbeat.beat(sink, kStart, 2);
  heartbeat.beat(sink, kStart, 3);
  heartbeat.leave(sink);
  heartbeat.leave(sink);
  EXPECT_THAT(sink.written,
              ElementsAre("-/robot", "cell/robot", "no -/robot", "cell/robot", "no cell/robot"));
}

TEST(Heartbeat, ReportsDegradedHealthIfTheMainLoopHangs) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.kick(kStart);
  heartbeat.set(status("-/robot"));
  heartbeat.beat(sink, kStart + Heartbeat::kHangs, 1);
  EXPECT_EQ(sink.last.health(), HEALTH_OK);
  heartbeat.beat(sink, kStart + seconds{3} + milliseconds{1}, 1);
  EXPECT_EQ(sink.last.health(), HEALTH_DEGRADED);
  EXPECT_THAT(sink.last.text().to_string(), HasSubstr("hanging for 3 s"));
  heartbeat.kick(kStart + seconds{3});
  heartbeat.beat(sink, kStart + seconds{3} + milliseconds{2}, 1);
  EXPECT_EQ(sink.last.health(), HEALTH_OK);
  EXPECT_EQ(sink.last.text().to_string(), "");
}

TEST(Heartbeat, DoesNotReplaceFailedHealthWhenTheMainLoopHangs) {
  Heartbeat heartbeat;
  FakeSink sink;
  DeviceStatus failed = status("cell/robot");
  failed.health(HEALTH_FAILED);
  heartbeat.kick(kStart);
  heartbeat.set(failed);
  heartbeat.beat(sink, kStart + seconds{10}, 1);
  EXPECT_EQ(sink.last.health(), HEALTH_FAILED);
}

TEST(Heartbeat, PublishesAChangedStatusAtOnce) {
  Heartbeat heartbeat;
  FakeSink sink;
  heartbeat.set(status("-/robot"));
  heartbeat.serve(sink);
  EXPECT_THAT(sink.written, ElementsAre("-/robot"));
  heartbeat.serve(sink);  // publishes the unchanged status at the next regular time
  EXPECT_THAT(sink.written, ElementsAre("-/robot", "-/robot"));
}

}  // namespace
}  // namespace takt::node::heartbeat_test
