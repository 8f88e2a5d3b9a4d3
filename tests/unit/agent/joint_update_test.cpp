#include <takt/agent/joint_update.hpp>

#include <gtest/gtest.h>

namespace takt::agent::joint_update_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Decision = JointUpdate::Decision;

struct OneDevice {
  explicit OneDevice(bool added = false) : update(added) {}
  JointUpdate update;
  Decision hears(Vote robot, Vote press = Vote::changed, Nanoseconds after = seconds{0}) {
    return update.step(from_ns(0) + after, {{"press", press}, {"robot", robot}});
  }
};

TEST(JointUpdate, IsKeptWhenAllDevicesHaveMadeTheirChanges) {
  OneDevice device;
  for (const Vote other : {Vote::nothing, Vote::absent, Vote::open})
    EXPECT_EQ(device.hears(other), Decision::wait);
  EXPECT_EQ(device.hears(Vote::changed), Decision::keep);
}

TEST(JointUpdate, IsKeptIfAnyDeviceHasKeptIt) {
  for (const Vote other : {Vote::nothing, Vote::absent, Vote::changed})
    EXPECT_EQ(OneDevice{}.hears(Vote::kept, other), Decision::keep);
}

TEST(JointUpdate, IsUndoneWhenADeviceHasUndoneIt) {
  OneDevice device;
  EXPECT_EQ(device.hears(Vote::undone, Vote::nothing), Decision::undo);
  EXPECT_EQ(device.update.why(), "device robot has not made its changes");
}

TEST(JointUpdate, IsUndoneIfALiveNodeDoesNotMentionItForTenSeconds) {
  OneDevice device;
  EXPECT_EQ(device.hears(Vote::absent), Decision::wait) << "its status may be on the way";
  EXPECT_EQ(device.hears(Vote::absent, Vote::changed, seconds{10}), Decision::wait);
  EXPECT_EQ(device.hears(Vote::absent, Vote::changed, milliseconds{10001}), Decision::undo);
}

TEST(JointUpdate, IsNotDecidedWhileADeviceIsLost) {
  OneDevice device;
  for (const int second : {0, 11, 3600})
    EXPECT_EQ(device.hears(Vote::absent, Vote::nothing, seconds{second}), Decision::wait)
        << "the lost device may have kept the update";
}

TEST(JointUpdate, IsKeptByAnAddedDeviceOnlyAfterAnotherDeviceHasKeptIt) {
  EXPECT_EQ(OneDevice{true}.hears(Vote::changed), Decision::wait);
  EXPECT_EQ(OneDevice{true}.hears(Vote::kept), Decision::keep);
}

TEST(JointUpdate, IsKeptAtOnceByTheOnlyDeviceOfACell) {
  JointUpdate update{false};
  EXPECT_EQ(update.step(from_ns(0), {}), Decision::keep);
}

}  // namespace
}  // namespace takt::agent::joint_update_test
