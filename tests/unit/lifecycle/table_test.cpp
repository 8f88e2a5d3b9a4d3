#include <takt/lifecycle/table.hpp>

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <tuple>

#include <takt/lifecycle/machine.hpp>

namespace takt::lifecycle::table_test {
namespace {

// The lifecycle table of the design, written by hand independently of the product. The product must reject
// every event that this table does not list.
const std::map<std::tuple<std::string, std::string>, std::string> kExpected{
    {{"IDLE", "initialize"}, "INITIALIZE"},   {{"INITIALIZE", "start"}, "START"},
    {{"START", "run"}, "EXECUTING"},          {{"EXECUTING", "stop"}, "START"},
    {{"INITIALIZE", "error"}, "RECOVER"},     {{"START", "error"}, "RECOVER"},
    {{"EXECUTING", "error"}, "RECOVER"},      {{"RECOVER", "recover"}, "(before)"},
    {{"RECOVER", "give up"}, "DESTRUCT"},     {{"IDLE", "destruct"}, "DESTRUCT"},
    {{"INITIALIZE", "destruct"}, "DESTRUCT"}, {{"START", "destruct"}, "DESTRUCT"},
    {{"EXECUTING", "destruct"}, "DESTRUCT"},  {{"RECOVER", "destruct"}, "DESTRUCT"},
    {{"DESTRUCT", "reset"}, "IDLE"},
};

TEST(LifecycleTable, MatchesTheDesignForEveryStateAndEvent) {
  for (State before : kStates) {
    for (State state : kStates) {
      for (Event event : kEvents) {
        const auto expected = kExpected.find({to_text(state), to_text(event)});
        const auto actual = next(state, event, before);
        SCOPED_TRACE(std::string{to_text(state)} + " + " + to_text(event));
        ASSERT_EQ(actual.has_value(), expected != kExpected.end());
        if (!actual) continue;
        std::string word = expected->second;
        if (word == "(before)") word = before == State::executing ? "EXECUTING" : "START";
        EXPECT_EQ(to_text(*actual), word);
      }
    }
  }
}

TEST(LifecycleMachine, RecoversToTheStateInWhichTheErrorOccurred) {
  for (bool running : {false, true}) {
    Machine machine;
    ASSERT_TRUE(machine.apply(Event::initialize));
    ASSERT_TRUE(machine.apply(Event::start));
    if (running) {
      ASSERT_TRUE(machine.apply(Event::run));
    }
    const State before = machine.state();
    ASSERT_TRUE(machine.apply(Event::error));
    EXPECT_EQ(machine.state(), State::recover);
    ASSERT_TRUE(machine.apply(Event::recover));
    EXPECT_EQ(machine.state(), before);
  }
}

TEST(LifecycleMachine, IsInStartAfterRecoveryFromAFailedStart) {
  Machine machine;
  ASSERT_TRUE(machine.apply(Event::initialize));
  ASSERT_TRUE(machine.apply(Event::error));
  ASSERT_TRUE(machine.apply(Event::recover));
  EXPECT_EQ(machine.state(), State::start);
}

TEST(LifecycleMachine, RejectsAnEventThatItsStateDoesNotAllow) {
  Machine machine;
  const auto rejected = machine.apply(Event::start);
  ASSERT_FALSE(rejected);
  EXPECT_EQ(rejected.problems()[0].what, "start is not allowed in state IDLE");
  EXPECT_EQ(rejected.problems()[0].fix, "it is allowed in INITIALIZE");
  EXPECT_EQ(machine.state(), State::idle);
  EXPECT_EQ(machine.sequence(), 0U);
}

TEST(LifecycleMachine, NumbersItsTransitionsWithoutGaps) {
  Machine machine;
  std::uint64_t expected = 0;
  for (Event event : {Event::initialize, Event::start, Event::run, Event::run, Event::stop, Event::destruct,
                      Event::reset}) {
    const auto step = machine.apply(event);
    if (step) {
      EXPECT_EQ(step->sequence, ++expected);
    }
  }
  EXPECT_EQ(machine.sequence(), 6U);
}

}  // namespace
}  // namespace takt::lifecycle::table_test
