#include <takt/agent/joint_start.hpp>

#include <gtest/gtest.h>

namespace takt::agent::joint_start_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Stage = JointStart::Stage;

const Instant kT0 = from_ns(10'000'000'000);

struct OneDevice {
  JointStart start{kT0};
  Stage hears(Nanoseconds after_t0, Heard robot, Heard press = Heard::running) {
    start.step(kT0 + after_t0, {{"press", press}, {"robot", robot}});
    return start.stage();
  }
};

TEST(JointStart, BeginsOnlyWhenAllOtherDevicesAreArmed) {
  OneDevice device;
  for (const Heard missing : {Heard::nothing, Heard::ended, Heard::prepared}) {
    EXPECT_EQ(device.hears(-milliseconds{200}, missing), Stage::armed);
    EXPECT_EQ(device.hears(-milliseconds{200}, Heard::armed, missing), Stage::armed);
  }
  EXPECT_EQ(device.hears(-milliseconds{200}, Heard::armed, Heard::armed), Stage::begun);
}

TEST(JointStart, BeginsAtMost300MsBeforeT0ToNoticeLostDevices) {
  OneDevice device;
  EXPECT_EQ(device.hears(-milliseconds{301}, Heard::armed), Stage::armed);
  EXPECT_EQ(device.hears(-milliseconds{300}, Heard::nothing), Stage::armed);
  EXPECT_EQ(device.hears(-milliseconds{100}, Heard::armed), Stage::begun);
}

TEST(JointStart, FailsAtT0IfADeviceIsNotArmed) {
  OneDevice device;
  device.hears(-milliseconds{1}, Heard::prepared, Heard::armed);
  EXPECT_EQ(device.hears(milliseconds{0}, Heard::prepared, Heard::armed), Stage::failed);
  EXPECT_EQ(device.start.why(), "T0 came before it was heard from robot");
}

TEST(JointStart, RunsOnceAllOtherDevicesHaveReportedThatTheyRun) {
  OneDevice device;
  device.hears(-milliseconds{1}, Heard::armed);
  EXPECT_EQ(device.hears(milliseconds{0}, Heard::armed), Stage::started);
  EXPECT_EQ(device.hears(seconds{1}, Heard::nothing), Stage::started) << "the network may be busy";
  EXPECT_EQ(device.hears(seconds{2}, Heard::started, Heard::started), Stage::running);
  EXPECT_EQ(device.hears(seconds{60}, Heard::nothing), Stage::running) << "the start is over";
}

TEST(JointStart, FailsIfADeviceDoesNotReportInTimeThatItRuns) {
  for (const Heard silent : {Heard::nothing, Heard::armed}) {
    OneDevice device;
    device.hears(-milliseconds{1}, Heard::armed);
    EXPECT_EQ(device.hears(JointStart::kHeardWithin, silent), Stage::started);
    EXPECT_EQ(device.hears(JointStart::kHeardWithin + milliseconds{1}, silent), Stage::failed);
    EXPECT_EQ(device.start.why(), "within 3 s of T0 it was not heard to run on robot");
  }
}

TEST(JointStart, FailsAtOnceIfADeviceHasEndedTheDeployment) {
  for (const milliseconds at : {milliseconds{-50}, milliseconds{50}}) {
    OneDevice device;
    device.hears(-milliseconds{100}, Heard::armed);
    EXPECT_EQ(device.hears(at, Heard::ended), Stage::failed);
    EXPECT_EQ(device.start.why(), "it does not run on robot");
  }
}

TEST(JointStart, StartsACellOfOneDeviceAtT0) {
  JointStart start{kT0};
  start.step(kT0 - milliseconds{1}, {});
  EXPECT_EQ(start.stage(), Stage::begun);
  start.step(kT0, {});
  EXPECT_EQ(start.stage(), Stage::running);
}

}  // namespace
}  // namespace takt::agent::joint_start_test
