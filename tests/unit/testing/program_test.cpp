// Tests the test harness with a periodic program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>

namespace program_test {
namespace {

using namespace std::chrono_literals;
using takt::ErrorType;
using takt::lifecycle::State;
using takt::testing::Error;
using takt::testing::Module;
using ::testing::HasSubstr;

basic::Number number(double value) {
  basic::Number result;
  result.value(value);
  return result;
}

TEST(TestedProgram, ShowsTheLinesThatItLogs) {
  Module module;
  ASSERT_TRUE(module.set("how", "logs"));
  ASSERT_TRUE(module.start());
  module.step(3);
  ASSERT_EQ(module.log().size(), 3U);
  EXPECT_EQ(module.log()[2].text, "body 3");
  EXPECT_EQ(module.log()[2].level, takt::LogLevel::error);
}

TEST(TestedProgram, KeepsItsLogLevelWhenItIsStartedAgain) {
  Module module;
  ASSERT_TRUE(module.set("how", "logs"));
  ASSERT_TRUE(module.set("log-level", "debug"));
  ASSERT_TRUE(module.start());
  ASSERT_TRUE(module.crash());
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(*module.get("log-level"), "debug");
}

TEST(Program, RunsABodyAtEachRelease) {
  Module module{{.period = 1us}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(out.count(), 0U);
  in.write(number(7));
  EXPECT_EQ(module.step(3), 3U);
  EXPECT_EQ(out.count(), 3U);
  EXPECT_EQ(out.value().value(), 7 + 200 + 100'000'000 + 10);
  module.miss(4);
  module.step();
  EXPECT_EQ(out.value().value(), 7 + 700 + 100'000'000 + 10);
}

TEST(Program, RunsAHundredThousandBodies) {
  Module module;
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(100'000), 100'000U);
  EXPECT_EQ(out.count(), 100'000U);
}

TEST(Program, GoesThroughTheLifecycle) {
  Module module;
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.initialize());
  EXPECT_EQ(module.state(), State::initialize);
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.state(), State::start);
  module.step();
  EXPECT_EQ(module.state(), State::executing);
  ASSERT_TRUE(module.destruct());
  EXPECT_EQ(module.state(), State::destruct);
  EXPECT_EQ(out.value().value(), -1);  // the program's atexit() function has written this value
}

TEST(Program, StartsEachTimeWithNewVariables) {
  Module module{{.period = 1us}};
  auto& out = module.out<basic::Count>("out");
  for (int life = 0; life < 3; ++life) {
    ASSERT_TRUE(module.start());
    module.step();
    EXPECT_EQ(out.value().value() % 100, 10);
    ASSERT_TRUE(module.destruct());
    ASSERT_TRUE(module.reset());
  }
}

TEST(Program, IsRestartedAfterItEnded) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.start());
  module.step(5);
  in.write(number(2000));
  EXPECT_EQ(module.step(5), 1U);
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().type, ErrorType::crash);
  EXPECT_EQ(module.last_error().text, "main() returned 6");
  EXPECT_EQ(module.last_error().cycle, 5U);
  EXPECT_EQ(out.value().value(), -1);
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(5), 1U) << "the restored input value ends the program again";
  in.write(number(0));
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.state(), State::executing);
  EXPECT_EQ(module.step(5), 5U);
}

TEST(Program, HasFinishedAfterItEndedWithStatus0) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.start());
  module.step(5);
  in.write(number(3000));
  EXPECT_EQ(module.step(5), 1U);
  EXPECT_EQ(module.state(), State::destruct);
  EXPECT_EQ(module.last_error().type, ErrorType::none);
  EXPECT_EQ(out.value().value(), -1) << "the program's atexit() functions ran";
  ASSERT_TRUE(module.reset());
  in.write(number(0));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(5), 5U);
}

TEST(Program, IsRestartedAfterACrash) {
  Module module;
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.start());
  module.step(5);
  const auto last = out.value().value();
  ASSERT_TRUE(module.crash());
  EXPECT_EQ(module.last_error().type, ErrorType::crash);
  EXPECT_EQ(module.step(5), 0U);
  EXPECT_EQ(out.value().value(), last) << "a crash calls no atexit() function";
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(5), 5U);
}

TEST(Program, RestoresItsSavedValueAfterACrash) {
  Module module;
  auto& out = module.out<basic::Count>("out");
  ASSERT_TRUE(module.set("how", "saves"));
  ASSERT_TRUE(module.start());
  module.step(5);
  EXPECT_EQ(out.value().value(), 50);
  for (const int bodies : {6, 7}) {
    ASSERT_TRUE(module.crash());
    ASSERT_TRUE(module.recover());
    module.step();
    EXPECT_EQ(out.value().value(), bodies * 10 + 1);
  }
}

TEST(Program, CanCallExitInACatchBlock) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  ASSERT_TRUE(module.start());
  in.write(number(-1));
  module.step();
  EXPECT_EQ(module.last_error().text, "the program called exit(5)");
  EXPECT_EQ(std::current_exception(), nullptr);
}

TEST(Program, CanWaitForItsPeriodInACatchBlock) {
  Module module;
  ASSERT_TRUE(module.set("how", "waits_in_catch"));
  auto& in = module.in<basic::Number>("in");
  ASSERT_TRUE(module.start());
  in.write(number(-1));
  module.step();
  EXPECT_EQ(std::current_exception(), nullptr);
  EXPECT_EQ(module.step(3), 3U);
  EXPECT_TRUE(module.healthy());
}

TEST(Program, ReportsWhyItDidNotStart) {
  const std::pair<const char*, const char*> ways[] = {
      {"return", "main() returned 3 before it called initPeriodExe()"},
      {"exit", "the program called exit(1) before it called initPeriodExe()"},
      {"throw", "main() threw: no file before it called initPeriodExe()"},
      {"wait", "waitPeriod(): call initPeriodExe() or initSporadicExe() first"},
      {"sporadic",
       "initSporadicExe(): the test declares the module periodic; use initPeriodExe() and waitPeriod()"},
      {"wrong_wait", "waitSporadic(): the module is periodic; call waitPeriod()"},
      {"late_port", "initPeriodExe(): port 'later' was created after this call"},
      {"twice", "initPeriodExe(): called twice; call it once, before the first wait"},
      {"attached", "the program called exit(4) before its first release was served"}};
  for (const auto& [how, text] : ways) {
    Module module;
    ASSERT_TRUE(module.set("how", how));
    EXPECT_THAT(module.start().text(), HasSubstr(text)) << how;
    EXPECT_EQ(module.runs(), 0U);
  }
}

TEST(Program, HasThePortsDeclaredInMainAfterInitialization) {
  Module module;
  EXPECT_THROW(module.out<basic::Number>("late"), Error);
  ASSERT_TRUE(module.initialize());
  module.out<basic::Number>("late");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(2), 2U);
}

TEST(Program, AcceptsPropertiesOnlyBeforeItStartsIfItDeclaresNone) {
  Module module;
  ASSERT_TRUE(module.set("speed", "1"));
  ASSERT_TRUE(module.start());
  EXPECT_THAT(module.set("speed", "2").text(),
              HasSubstr("the program declares no properties: it gets them as arguments when it starts"));
}

}  // namespace
}  // namespace program_test
