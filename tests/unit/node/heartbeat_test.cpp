#include "heartbeat.hpp"

#include <gmock/gmock.h>

#include <string>
#include <vector>

#include <takt/dds/words.hpp>

namespace takt::node::heartbeat_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

class Line final : public DeviceLine {
 public:
  void write(const DeviceStatus& status) override {
    said.push_back(status.path().to_string());
    last = status;
  }
  void dispose(const DeviceStatus& key) override { said.push_back("no " + key.path().to_string()); }

  std::vector<std::string> said;
  DeviceStatus last;
};

DeviceStatus status(const std::string& path) {
  DeviceStatus s;
  dds::set(s.path(), path);
  return s;
}

constexpr Instant kStart = from_ns(1'000'000'000);

TEST(Heartbeat, SaysNothingBeforeThereIsSomethingToSay) {
  Heartbeat heartbeat;
  Line line;
  heartbeat.beat(line, kStart, 1);
  heartbeat.leave(line);
  EXPECT_TRUE(line.said.empty());
}

TEST(Heartbeat, SaysTheSameAgainWithItsOwnNumberAndTime) {
  Heartbeat heartbeat;
  Line line;
  heartbeat.sign(kStart);
  heartbeat.set(status("-/robot"));
  heartbeat.beat(line, kStart, 10);
  heartbeat.beat(line, kStart + milliseconds{100}, 20);
  EXPECT_THAT(line.said, ElementsAre("-/robot", "-/robot"));
  EXPECT_EQ(line.last.sequence_number(), 2U);
  EXPECT_EQ(line.last.time_ns(), 20);
}

TEST(Heartbeat, TakesBackTheOldKeyAfterItSaidTheNew) {
  Heartbeat heartbeat;
  Line line;
  heartbeat.set(status("-/robot"));
  heartbeat.beat(line, kStart, 1);
  heartbeat.set(status("cell/robot"));
  heartbeat.beat(line, kStart, 2);
  heartbeat.beat(line, kStart, 3);
  heartbeat.leave(line);
  heartbeat.leave(line);
  EXPECT_THAT(line.said, ElementsAre("-/robot", "cell/robot", "no -/robot", "cell/robot", "no cell/robot"));
}

TEST(Heartbeat, TellsOfAMainLoopThatHangs) {
  Heartbeat heartbeat;
  Line line;
  heartbeat.sign(kStart);
  heartbeat.set(status("-/robot"));
  heartbeat.beat(line, kStart + Heartbeat::kHangs, 1);
  EXPECT_EQ(line.last.health(), HEALTH_OK);
  heartbeat.beat(line, kStart + seconds{3} + milliseconds{1}, 1);
  EXPECT_EQ(line.last.health(), HEALTH_DEGRADED);
  EXPECT_THAT(line.last.text().to_string(), HasSubstr("hanging for 3 s"));
  heartbeat.sign(kStart + seconds{3});
  heartbeat.beat(line, kStart + seconds{3} + milliseconds{2}, 1);
  EXPECT_EQ(line.last.health(), HEALTH_OK);
  EXPECT_EQ(line.last.text().to_string(), "");
}

TEST(Heartbeat, ADeviceThatHasFailedDoesNotLookBetterForHanging) {
  Heartbeat heartbeat;
  Line line;
  DeviceStatus failed = status("cell/robot");
  failed.health(HEALTH_FAILED);
  heartbeat.sign(kStart);
  heartbeat.set(failed);
  heartbeat.beat(line, kStart + seconds{10}, 1);
  EXPECT_EQ(line.last.health(), HEALTH_FAILED);
}

TEST(Heartbeat, AChangeIsSaidAtOnce) {
  Heartbeat heartbeat;
  Line line;
  heartbeat.set(status("-/robot"));
  heartbeat.serve(line);
  EXPECT_THAT(line.said, ElementsAre("-/robot"));
  heartbeat.serve(line);  // the next beat
  EXPECT_THAT(line.said, ElementsAre("-/robot", "-/robot"));
}

}  // namespace
}  // namespace takt::node::heartbeat_test
