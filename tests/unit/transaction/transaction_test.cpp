#include <takt/transaction/transaction.hpp>

#include <gtest/gtest.h>

namespace takt::transaction::transaction_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::int64_t kT0 = 100'000'000'000;
constexpr Heard kPrepared{.stage = Stage::prepared};
constexpr Heard kArmed{.stage = Stage::armed, .t0_ns = kT0};
constexpr Heard kRunning{.stage = Stage::running, .t0_ns = kT0};
constexpr Heard kUndone{.stage = Stage::undone, .t0_ns = kT0};
constexpr Heard kFinal{.stage = Stage::final, .t0_ns = kT0};

std::int64_t after_t0(Nanoseconds time) { return kT0 + time.count(); }

// A device in a cell with the devices press and robot.
struct Device {
  State state{.operator_heard_ns = after_t0(-seconds{1})};

  Stage hears(Nanoseconds since_t0, std::optional<Heard> robot, std::optional<Heard> press) {
    state = next(state, {{"press", press}, {"robot", robot}}, after_t0(since_t0));
    return state.stage;
  }
};
Device in(Stage stage) {
  Device device;
  device.state.stage = stage;
  device.state.t0_ns = stage == Stage::prepared ? 0 : kT0;
  return device;
}

TEST(Transaction, IsArmedByTheOperatorsT0) {
  const auto armed = receive_t0(in(Stage::prepared).state, kT0, after_t0(-seconds{1}));
  ASSERT_TRUE(armed) << to_text(armed.problems());
  EXPECT_EQ(*armed, in(Stage::armed).state);
  EXPECT_EQ(*receive_t0(*armed, kT0, after_t0(seconds{1})), *armed) << "the operator may repeat T0";
}

TEST(Transaction, RejectsAT0ThatItCannotKeep) {
  const auto answer = [](Stage stage, std::int64_t t0_ns, Nanoseconds since_t0) {
    const auto accepted = receive_t0(in(stage).state, t0_ns, after_t0(since_t0));
    return accepted ? "accepted" : accepted.problems()[0].what;
  };
  EXPECT_EQ(answer(Stage::prepared, kT0, milliseconds{5}), "the start time passed 5 ms ago");
  EXPECT_EQ(answer(Stage::prepared, kT0, -seconds{61}),
            "the start time is 61 s in the future, more than the allowed 60 s");
  EXPECT_EQ(answer(Stage::armed, kT0 + 1, -seconds{1}), "it already has another start time");
  EXPECT_EQ(answer(Stage::undone, kT0, -seconds{1}), "it has been undone: ");
}

TEST(Transaction, IsArmedByAnotherDeviceIfTheOperatorIsLost) {
  Device device = in(Stage::prepared);
  EXPECT_EQ(device.hears(-seconds{1}, kArmed, {}), Stage::armed);
  EXPECT_EQ(device.state.t0_ns, kT0);
  Device late = in(Stage::prepared);
  EXPECT_EQ(late.hears(milliseconds{0}, kRunning, kArmed), Stage::undone);
  EXPECT_EQ(late.state.why, "the start time passed 0 ns ago; synchronise the clocks of the devices");
}

TEST(Transaction, IsUndoneIfTheOperatorIsSilentBeforeT0IsKnown) {
  Device device = in(Stage::prepared);
  device.state.operator_heard_ns = 0;
  device.state = next(device.state, {{"robot", kPrepared}}, kOperatorSilent.count());
  EXPECT_EQ(device.state.stage, Stage::prepared);
  device.state = next(device.state, {{"robot", kPrepared}}, kOperatorSilent.count() + 1);
  EXPECT_EQ(device.state.stage, Stage::undone);
  EXPECT_EQ(device.state.why, "no message of the operator arrived within 10 s");
}

TEST(Transaction, BeginsShortlyBeforeT0IfAllOthersAreArmed) {
  Device device = in(Stage::armed);
  EXPECT_EQ(device.hears(-kBegins - Nanoseconds{1}, kArmed, kArmed), Stage::armed);
  EXPECT_EQ(device.hears(-kBegins, kArmed, {}), Stage::armed) << "press is lost";
  EXPECT_EQ(device.hears(-kBegins, kArmed, kPrepared), Stage::armed);
  EXPECT_EQ(device.hears(-kBegins, Heard{.stage = Stage::armed, .t0_ns = kT0 + 1}, kArmed), Stage::armed)
      << "robot has another T0";
  EXPECT_EQ(device.hears(-kBegins, kRunning, kArmed), Stage::running);
}

TEST(Transaction, IsUndoneAtT0IfADeviceIsNotArmed) {
  Device device = in(Stage::armed);
  EXPECT_EQ(device.hears(Nanoseconds{-1}, kArmed, {}), Stage::armed);
  EXPECT_EQ(device.hears(Nanoseconds{0}, kPrepared, {}), Stage::undone);
  EXPECT_EQ(device.state.why, "press, robot were not heard to be ready before T0");
}

TEST(Transaction, IsFinalOnceAllOthersRun) {
  Device device = in(Stage::running);
  EXPECT_EQ(device.hears(Nanoseconds{-1}, kRunning, kRunning), Stage::running) << "T0 has not come";
  EXPECT_EQ(device.hears(seconds{1}, kRunning, {}), Stage::running) << "the network may be busy";
  EXPECT_EQ(device.hears(seconds{2}, kRunning, kRunning), Stage::final);
  EXPECT_EQ(device.hears(seconds{60}, {}, kUndone), Stage::final) << "the others will hear that it is final";
}

TEST(Transaction, IsUndoneIfADeviceIsNotHeardToRunInTime) {
  for (const auto& silent : {std::optional<Heard>{}, std::optional{kArmed}}) {
    Device device = in(Stage::running);
    EXPECT_EQ(device.hears(kHeardWithin, silent, kRunning), Stage::running);
    EXPECT_EQ(device.hears(kHeardWithin + Nanoseconds{1}, silent, kRunning), Stage::undone);
    EXPECT_EQ(device.state.why, "robot was not heard to run within 3 s of T0");
  }
}

TEST(Transaction, IsUndoneWhenAnotherDeviceHasUndoneIt) {
  for (const Stage stage : {Stage::prepared, Stage::armed, Stage::running}) {
    Device device = in(stage);
    EXPECT_EQ(device.hears(-seconds{1}, kUndone, kArmed), Stage::undone);
    EXPECT_EQ(device.state.why, "device robot has undone it");
  }
}

TEST(Transaction, GoesForwardAgainWhenAnotherDeviceIsFinal) {
  Device device = in(Stage::undone);
  device.state.why = "a cable was pulled";
  EXPECT_EQ(device.hears(seconds{60}, kUndone, kFinal), Stage::final);
  EXPECT_EQ(device.state.why, "");
}

TEST(Transaction, IsUndoneByAFailureUnlessItIsFinal) {
  for (const Stage stage : {Stage::prepared, Stage::armed, Stage::running}) {
    const State failed = fail(in(stage).state, "servo did not start");
    EXPECT_EQ(failed.stage, Stage::undone);
    EXPECT_EQ(failed.why, "servo did not start");
    EXPECT_EQ(fail(failed, "another reason"), failed) << "the first reason stays";
  }
  EXPECT_EQ(fail(in(Stage::final).state, "servo did not start"), in(Stage::final).state);
}

TEST(Transaction, IsSettledOnceAllOthersHaveTheSameEnd) {
  const State undone = in(Stage::undone).state;
  EXPECT_TRUE(settled(undone, {}));
  EXPECT_TRUE(settled(undone, {{"press", kUndone}, {"robot", kUndone}}));
  EXPECT_FALSE(settled(undone, {{"press", kUndone}, {"robot", std::nullopt}})) << "robot may be final";
  EXPECT_FALSE(settled(undone, {{"press", kUndone}, {"robot", kRunning}})) << "robot may become final";
  EXPECT_TRUE(settled(in(Stage::final).state, {{"press", kFinal}}));
  EXPECT_FALSE(settled(in(Stage::running).state, {{"press", kRunning}}));
}

TEST(Transaction, OfOneDeviceNeedsOnlyT0) {
  State state = in(Stage::armed).state;
  state = next(state, {}, after_t0(-kBegins));
  EXPECT_EQ(state.stage, Stage::running);
  EXPECT_EQ(next(state, {}, kT0).stage, Stage::final);
}

}  // namespace
}  // namespace takt::transaction::transaction_test
