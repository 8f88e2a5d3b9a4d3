// Tests the test harness with a C++ component.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>
#include <line.hpp>

namespace component_test {
namespace {

using namespace std::chrono_literals;
using takt::ErrorType;
using takt::lifecycle::State;
using takt::testing::Error;
using takt::testing::Module;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::StartsWith;

basic::Number number(double value) {
  basic::Number result;
  result.value(value);
  return result;
}

template <class Call>
std::string error_of(Call&& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

std::vector<std::int64_t> values_of(const takt::testing::Out<basic::Count>& out) {
  std::vector<std::int64_t> all;
  for (const basic::Count& count : out.values()) all.push_back(count.value());
  return all;
}

TEST(TestedComponent, ShowsTheLinesThatItLogs) {
  Module module;
  ASSERT_TRUE(module.set("how", "nothing"));
  ASSERT_TRUE(module.start());
  module.step(2);
  ASSERT_EQ(module.log().size(), 1U);
  EXPECT_EQ(module.log()[0].text, "started with nothing");
  EXPECT_EQ(module.log()[0].level, takt::LogLevel::info);
  EXPECT_EQ(*module.get("log-level"), "info");
  EXPECT_EQ(module.set("log-level", "debugs").text(),
            "property 'log-level' cannot be 'debugs'; did you mean debug?");
  ASSERT_TRUE(module.set("log-level", "debug"));
  EXPECT_EQ(*module.get("log-level"), "debug");
  module.step(200);
  ASSERT_EQ(module.log().size(), 201U);
  EXPECT_EQ(module.log()[200].text, "gain is 2");
  EXPECT_EQ(module.log()[200].cycle, 201U);
}

TEST(TestedComponent, ReadsItsInputsAndWritesItsOutputs) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(3));
  EXPECT_EQ(module.step(), 1U);
  EXPECT_EQ(out.value().value(), 6);
  in.write(number(1));
  in.write(number(4));
  EXPECT_EQ(module.step(10), 10U);
  EXPECT_EQ(out.value().value(), 8);
  EXPECT_EQ(out.values().size(), 10U);
  EXPECT_EQ(out.count(), 11U);
  EXPECT_EQ(in.overwritten(), 1U);
}

TEST(TestedComponent, GetsTheNewestSamplesOfAFullQueue) {
  Module module;
  auto& orders = module.in<basic::Count>("orders", {.queue = 4});
  auto& out = module.out<basic::Count>("events");
  ASSERT_TRUE(module.start());
  for (int order = 1; order <= 6; ++order) {
    basic::Count count;
    count.value(order);
    orders.write(count);
  }
  module.step();
  EXPECT_THAT(values_of(out), ElementsAre(3, 4, 5, 6));
  EXPECT_EQ(orders.overwritten(), 2U);
}

TEST(TestedComponent, RunsAMillionCyclesOnItsGrid) {
  Module module{{.period = 10us}};
  ASSERT_TRUE(module.set("how", "time"));
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  const takt::Instant begin = module.next_release();
  EXPECT_EQ(module.step(1'000'000), 1'000'000U);
  EXPECT_EQ(out.value().value(), static_cast<double>(takt::to_ns(begin + 999'999 * 10us)));
  EXPECT_EQ(out.values().size(), out.kMost);
  EXPECT_EQ(out.count(), 1'000'000U);
}

TEST(TestedComponent, GetsTheConfiguredPeriod) {
  Module module{{.period = 250us}};
  ASSERT_TRUE(module.set("how", "period"));
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_DOUBLE_EQ(out.value().value(), 250e-6);
}

TEST(TestedComponent, SeesAGapInItsCycleNumbersAfterMissedReleases) {
  Module module;
  ASSERT_TRUE(module.set("how", "number"));
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  module.step(2);
  module.miss(3);
  EXPECT_EQ(module.step(), 1U);
  EXPECT_EQ(out.value().value(), 5);
  EXPECT_EQ(module.missed(), 3U);
  module.step();
  EXPECT_EQ(out.value().value(), 6);
}

TEST(TestedComponent, SeesTheAgeOfASample) {
  Module module{{.period = 1ms}};
  ASSERT_TRUE(module.set("how", "age"));
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(1));
  module.step();
  EXPECT_EQ(out.value().value(), 0);
  in.write(number(1), 5ms);
  module.step();
  EXPECT_EQ(out.value().value(), 5e6);
  module.step(2);
  EXPECT_EQ(out.value().value(), 7e6);
}

TEST(TestedComponent, IsConnectedOnlyAtPortsThatTheTestNames) {
  for (const bool named : {false, true}) {
    Module module;
    ASSERT_TRUE(module.set("how", "tied"));
    if (named) module.in<basic::Number>("in");
    auto& out = module.out<basic::Number>("out");
    ASSERT_TRUE(module.start());
    module.step();
    EXPECT_EQ(out.value().value(), named ? 1 : 0);
  }
}

TEST(TestedComponent, HasItsPropertiesValidatedAsInADescriptor) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  EXPECT_EQ(module.set("gain", "11").text(),
            "property 'gain' cannot be '11'; it takes a number, 0 to 10");
  EXPECT_THAT(module.set("gian", "1").text(), HasSubstr("has no property 'gian'; did you mean gain?"));
  ASSERT_TRUE(module.set("gain", "3"));
  ASSERT_TRUE(module.start());
  in.write(number(1));
  module.step();
  EXPECT_EQ(out.value().value(), 3);
  ASSERT_TRUE(module.set("gain", "5"));
  EXPECT_EQ(*module.get("gain"), "5");
  module.step();
  EXPECT_EQ(out.value().value(), 5);
  EXPECT_FALSE(module.set("gain", "-1"));
  module.step();
  EXPECT_EQ(out.value().value(), 5);
}

TEST(TestedComponent, GetsItsHooksCalledInLifecycleOrder) {
  Module module;
  auto& out = module.out<basic::Count>("events");
  ASSERT_TRUE(module.initialize());
  EXPECT_EQ(module.state(), State::initialize);
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.state(), State::start);
  EXPECT_THAT(values_of(out), ElementsAre(-1, -2));
  module.step();
  EXPECT_EQ(module.state(), State::executing);
  ASSERT_TRUE(module.stop());
  EXPECT_EQ(module.state(), State::start);
  EXPECT_EQ(module.step(5), 0U);
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(5), 5U);
  ASSERT_TRUE(module.error(ErrorType::budget));
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().type, ErrorType::budget);
  EXPECT_EQ(module.step(5), 0U);
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.state(), State::executing);
  ASSERT_TRUE(module.destruct());
  EXPECT_THAT(values_of(out), ElementsAre(-3, -4));
  EXPECT_EQ(module.state(), State::destruct);
  EXPECT_EQ(module.step(5), 0U);
  ASSERT_TRUE(module.reset());
  EXPECT_EQ(module.state(), State::idle);
  EXPECT_THROW(module.step(), Error);
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(), 1U);
}

TEST(TestedComponent, IsReloadedAfterACrash) {
  Module module;
  auto& out = module.out<basic::Count>("events");
  EXPECT_FALSE(module.crash().ok()) << "not allowed in IDLE";
  ASSERT_TRUE(module.set("gain", "7"));
  ASSERT_TRUE(module.start());
  module.step(5);
  ASSERT_TRUE(module.crash());
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().type, ErrorType::crash);
  EXPECT_EQ(module.last_error().cycle, 5U);
  EXPECT_EQ(module.step(5), 0U);
  ASSERT_TRUE(module.set("starts", "false"));
  for (int attempt = 0; attempt < 2; ++attempt) EXPECT_EQ(module.recover().text(), "threw: the drive is off");
  ASSERT_TRUE(module.set("starts", "true"));
  ASSERT_TRUE(module.recover());
  EXPECT_THAT(values_of(out), ElementsAre(-1, -1, -1, -2))
      << "each attempt loads the module anew, without error() or destruct()";
  EXPECT_EQ(*module.get("gain"), "7");
  EXPECT_EQ(module.step(5), 5U);
}

TEST(TestedComponent, GetsTheLatestValueAgainAfterACrash) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  auto& orders = module.in<basic::Count>("orders", {.queue = 4});
  auto& out = module.out<basic::Number>("out");
  auto& done = module.out<basic::Count>("events");
  ASSERT_TRUE(module.start());
  in.write(number(3));
  orders.write({});
  module.step();
  EXPECT_EQ(out.value().value(), 6);
  ASSERT_TRUE(module.crash());
  ASSERT_TRUE(module.recover());
  const auto before = done.count();
  module.step();
  EXPECT_EQ(out.value().value(), 6);
  EXPECT_EQ(done.count(), before) << "a queued sample is read only once";
}

TEST(TestedComponent, KeepsPropertiesAndConnectionsAfterAReset) {
  Module module;
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.set("gain", "7"));
  ASSERT_TRUE(module.start());
  module.step();
  ASSERT_TRUE(module.destruct());
  ASSERT_TRUE(module.reset());
  ASSERT_TRUE(module.start());
  in.write(number(1));
  module.step();
  EXPECT_EQ(out.value().value(), 7);
}

TEST(TestedComponent, RejectsCommandsThatItsStateDoesNotAllow) {
  Module module;
  EXPECT_EQ(module.recover().text(), "recover is not allowed in state IDLE; it is allowed in RECOVER");
  EXPECT_FALSE(module.stop());
  EXPECT_FALSE(module.error(ErrorType::failure));
  EXPECT_FALSE(module.reset());
  ASSERT_TRUE(module.start());
  EXPECT_FALSE(module.start());
  EXPECT_FALSE(module.initialize());
  ASSERT_TRUE(module.destruct());
  EXPECT_FALSE(module.destruct());
  EXPECT_FALSE(module.start());
  EXPECT_FALSE(module.set("gain", "1"));
  EXPECT_EQ(module.state(), State::destruct);
}

TEST(TestedComponent, ReportsWhyAHookFailed) {
  Module module;
  ASSERT_TRUE(module.set("how", "initialize"));
  EXPECT_EQ(module.start().text(), "no air pressure; open the valve");
  EXPECT_EQ(module.state(), State::idle);
  ASSERT_TRUE(module.set("how", ""));
  ASSERT_TRUE(module.set("starts", "false"));
  EXPECT_EQ(module.start().text(), "threw: the drive is off");
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().type, ErrorType::start);
  ASSERT_TRUE(module.set("recovers", "false"));
  EXPECT_EQ(module.recover().text(), "still blocked");
  EXPECT_EQ(module.state(), State::recover);
}

TEST(TestedComponent, FailsIfItConstructsAPortOrAPropertyAfterItsConstructor) {
  for (const char* kind : {"port", "property"}) {
    Module module;
    ASSERT_TRUE(module.set("how", std::string{"late "} + kind));
    EXPECT_EQ(module.initialize().text(),
              std::string{kind} +
                  " 'late' was created after the constructor, so it would have no effect; make it a member "
                  "of the component, or create it in the constructor");
    EXPECT_EQ(module.state(), State::idle);
  }
}

TEST(TestedComponent, EndsAfterTheCycleInWhichItFinishes) {
  Module module;
  auto& out = module.out<basic::Number>("out");
  auto& events = module.out<basic::Count>("events");
  ASSERT_TRUE(module.set("how", "finish"));
  ASSERT_TRUE(module.set("at", "3"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(10), 4U);
  EXPECT_EQ(module.state(), State::destruct);
  EXPECT_EQ(module.last_error().type, ErrorType::none);
  EXPECT_THAT(values_of(events), ElementsAre(-4)) << "destruct() was called";
  EXPECT_EQ(out.count(), 4U) << "the last run wrote its sample";
  ASSERT_TRUE(module.reset());
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(10), 10U) << "the cycle in which it finishes is over";
}

TEST(TestedComponent, GoesToRecoverIfACycleBothFailsAndFinishes) {
  Module module;
  ASSERT_TRUE(module.set("how", "both"));
  ASSERT_TRUE(module.set("at", "3"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(10), 4U);
  EXPECT_EQ(module.state(), State::recover);
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(10), 10U);
}

TEST(TestedComponent, DoesNotFinishIfItCallsFinishInStart) {
  Module module;
  ASSERT_TRUE(module.set("how", "finish in start"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(10), 10U);
}

TEST(TestedComponent, GoesToRecoverIfACycleFails) {
  const std::pair<const char*, const char*> ways[] = {
      {"fail", "the axis is blocked"},
      {"throw", "division by zero"},
      {"other", "threw something that is not a std::exception"}};
  for (const auto& [how, text] : ways) {
    Module module;
    auto& out = module.out<basic::Count>("events");
    ASSERT_TRUE(module.set("how", how));
    ASSERT_TRUE(module.set("at", "3"));
    ASSERT_TRUE(module.start());
    EXPECT_TRUE(module.healthy());
    EXPECT_EQ(module.step(10), 4U);
    EXPECT_EQ(module.state(), State::recover);
    EXPECT_EQ(module.last_error().type, ErrorType::failure);
    EXPECT_EQ(module.last_error().text, text);
    EXPECT_EQ(module.last_error().cycle, 3U);
    EXPECT_EQ(module.healthy().text(),
              std::string{"the module has been in RECOVER since release 3: failure: "} + text);
    EXPECT_THAT(values_of(out), ElementsAre(-11));
    ASSERT_TRUE(module.recover());
    EXPECT_TRUE(module.healthy());
    EXPECT_EQ(module.step(10), 10U);
  }
}

TEST(TestedComponent, GoesToRecoverWhenAnInputIsStale) {
  Module module{{.period = 1ms}};
  auto& in = module.in<basic::Number>("in", {.deadline = 10ms, .stale_is_error = true});
  ASSERT_TRUE(module.start());
  in.write(number(1));
  EXPECT_EQ(module.step(20), 12U);  // in the last release, the input was stale and run() was not called
  EXPECT_EQ(module.last_error().type, ErrorType::stale);
  EXPECT_EQ(module.last_error().text, "the newest value of input 'in' is older than 10 ms");
  EXPECT_EQ(in.late(), 1U);
}

TEST(TestedComponent, CountsAnInvalidOutputValue) {
  Module module;
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.set("how", "bound"));
  ASSERT_TRUE(module.set("at", "0"));
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_EQ(state.unfit(), 1U);
  EXPECT_THAT(error_of([&] { static_cast<void>(state.value()); }),
              HasSubstr("nothing was written to output 'state'"));
}

TEST(TestedComponent, CanBeSteppedUntilAConditionHolds) {
  Module module;
  ASSERT_TRUE(module.set("how", "number"));
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  EXPECT_TRUE(module.step_until([&] { return out.value().value() == 41; }, 100));
  EXPECT_EQ(module.runs(), 42U);
  EXPECT_FALSE(module.step_until([] { return false; }, 100));
  EXPECT_EQ(module.runs(), 142U);
}

TEST(TestedComponent, SharesNoStateWithAnotherInstance) {
  Module one;
  Module other;
  ASSERT_TRUE(one.set("gain", "1"));
  auto& in = one.in<basic::Number>("in");
  auto& out = one.out<basic::Number>("out");
  auto& others = other.out<basic::Number>("out");
  ASSERT_TRUE(one.start());
  ASSERT_TRUE(other.start());
  in.write(number(9));
  one.step();
  other.step();
  EXPECT_EQ(out.value().value(), 9);
  EXPECT_EQ(others.value().value(), 0);
}

TEST(TestHarness, RejectsUnknownPortsAndInvalidSteps) {
  Module module;
  EXPECT_EQ(
      error_of([&] { module.in<basic::Number>("im"); }),
      "testing_subject.so has no port 'im'; it has in in (basic::Number), in orders (basic::Count), out "
      "out (basic::Number), out events (basic::Count), in belt (line::BeltState), out state "
      "(line::BeltState)");
  EXPECT_EQ(error_of([&] { module.in<basic::Number>("out"); }),
            "port 'out' of testing_subject.so is an output; use out<basic::Number>()");
  EXPECT_EQ(error_of([&] { module.out<basic::Number>("in"); }),
            "port 'in' of testing_subject.so is an input; use in<basic::Number>()");
  EXPECT_EQ(error_of([&] { module.in<basic::Count>("in"); }),
            "port 'in' of testing_subject.so has the type basic::Number, not basic::Count");
  line::BeltState state;
  state.mode(static_cast<line::BeltMode>(7));
  EXPECT_THAT(error_of([&] { module.in<line::BeltState>("belt").write(state); }),
              HasSubstr("the value does not fit type line::BeltState"));
  EXPECT_EQ(error_of([&] { module.step(); }), "step() is not allowed in state IDLE; call start() first");
  EXPECT_EQ(error_of([&] { module.in<basic::Number>("in", {.stale_is_error = true}); }),
            "without a deadline no value is stale; give the connection of 'in' a deadline");
  module.in<basic::Number>("in");
  EXPECT_THAT(error_of([&] { module.in<basic::Number>("in", {.queue = 8}); }),
              HasSubstr("port 'in' is connected already"));
}

TEST(TestHarness, RejectsUnusableFilesAndOptions) {
  const std::string misspelt = error_of([] { Module{{.file = "testing_subjcet.so"}}; });
  EXPECT_THAT(misspelt, StartsWith("there is no file testing_subjcet.so (looked in /"));
  EXPECT_THAT(misspelt, EndsWith("; did you mean testing_subject.so?"));
  EXPECT_THAT(error_of([] { Module{{.file = NOTHING}}; }), HasSubstr("has no function run()"));
  EXPECT_THAT(error_of([] { Module{{.file = "vision.exe"}}; }),
              HasSubstr("is a program and cannot be loaded"));
  EXPECT_THAT(error_of([] { Module{{.sporadic = true}}; }),
              HasSubstr("has neither condition() nor an event port"));
  EXPECT_THAT(error_of([] { Module{{.period = 0ms}}; }), HasSubstr("it must be positive"));
}

TEST(TestHarness, FindsAFileInTheFolderOfTheTestedComponent) {
  Module module{{.file = "testing_c_form.so"}};
  EXPECT_TRUE(module.start());
}

// Google Test prints this message if ASSERT_TRUE(module.start()) fails.
TEST(FailedCommand, ShowsItsReasonInGoogleTest) {
  Module module;
  ASSERT_TRUE(module.set("how", "initialize"));
  const ::testing::AssertionResult shown = module.start();
  EXPECT_FALSE(shown);
  EXPECT_STREQ(shown.message(), "no air pressure; open the valve");
}

}  // namespace
}  // namespace component_test
