#include <takt/simulation/simulation.hpp>

#include <algorithm>
#include <string>

#include <gmock/gmock.h>
#include <folders.hpp>
#include <full_form.hpp>

#include <takt/simulation/random_cell.hpp>
#include "simulated.hpp"

namespace takt::simulation::simulation_test {
namespace {

using simulated::Cell;
using simulated::module_of;
using simulated::Outcome;
using simulated::program;
using simulated::steps_of;
using simulated::thread;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(Simulation, TheSameSeedGivesTheSameRun) {
  const Cell cell = Cell::demo();
  const Options options{.seed = 7, .length = milliseconds{200}, .faults_per_second = 50};
  const Outcome first = cell.run(options);
  const Outcome second = cell.run(options);
  EXPECT_GT(first.lines.size(), 1000U);
  EXPECT_EQ(first.lines, second.lines);
  EXPECT_EQ(first.course.report, second.course.report);
}

TEST(Simulation, AnotherSeedGivesAnotherRun) {
  const Cell cell = Cell::demo();
  EXPECT_NE(cell.run({.seed = 1, .length = milliseconds{50}}).lines,
            cell.run({.seed = 2, .length = milliseconds{50}}).lines);
}

TEST(Simulation, RunsEveryRowOfTheGrid) {
  const Outcome run = Cell::of("<device name=\"d\">" + thread("a", "1000000") + thread("b", "4000000") +
                               program("p", "2000000") + "</device>")
                          .run({.length = seconds{1}});
  const auto& executor = run.course.report["devices"][0]["executors"][0];
  // The row that is due exactly at the end of the simulation does not run, because the executors stop before
  // it.
  EXPECT_EQ(1000, executor["cycles"]);
  EXPECT_EQ(0, executor["missed"]);
  EXPECT_EQ(1000, module_of(run, "a")["cycles"]);
  EXPECT_EQ(250, module_of(run, "b")["cycles"]);
  EXPECT_EQ(500, module_of(run, "p")["cycles"]);
}

TEST(Simulation, AModuleGoesThroughItsLifecycle) {
  const Outcome run = Cell::of("<device name=\"d\">" + thread("a", "1000000") + "</device>")
                          .run({.length = milliseconds{50}});
  EXPECT_THAT(steps_of(run, "d.a"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(run.course.failures, IsEmpty());
}

TEST(Simulation, ALateModuleCausesMissedRows) {
  const Cell cell = Cell::of("<device name=\"d\">" + thread("a", "1000000") + "</device>");
  const Outcome run = cell.run({.length = milliseconds{100}}, "at 10.5 ms d.a late 3 ms");
  EXPECT_EQ(98, module_of(run, "a")["cycles"]);
  EXPECT_EQ(1, module_of(run, "a")["overruns"]);
  EXPECT_EQ(2, run.course.report["devices"][0]["executors"][0]["missed"]);
  EXPECT_THAT(run.lines,
              Contains(HasSubstr("ran row 14, released at +0.014000000, missed rows before it: 2")));
}

TEST(Simulation, AModuleThatExceedsItsBudgetRecovers) {
  const Cell cell = Cell::of(
      "<device name=\"d\">" +
      thread("a", "1000000",
             "<budget>100000</budget><recovery attempts=\"3\" backoff=\"2000000\" then=\"destruct\"/>") +
      "</device>");
  const Outcome run =
      cell.run({.length = milliseconds{100}}, "at 20 ms d.a late 300 us\nat 20 ms d.a unmended 1");
  EXPECT_THAT(steps_of(run, "d.a"), testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER",
                                                         "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(run.lines, Contains(HasSubstr("d.a recovery, attempt 2 of 3")));
  EXPECT_EQ(1, module_of(run, "a")["errors"]);
}

TEST(Simulation, AModuleThatCannotRecoverIsGivenUp) {
  const auto with = [](const std::string& then) {
    return Cell::of("<device name=\"d\">" +
                    thread("a", "1000000",
                           "<recovery attempts=\"2\" backoff=\"1000000\" then=\"" + then + "\"/>") +
                    thread("b", "1000000") + "</device>")
        .run({.length = milliseconds{200}}, "at 20 ms d.a fail\nat 20 ms d.a unmended 5");
  };
  const Outcome alone = with("destruct");
  EXPECT_THAT(steps_of(alone, "d.a"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT"));
  EXPECT_EQ(200, module_of(alone, "b")["cycles"]);
  EXPECT_THAT(to_text(alone.course.failures), HasSubstr("module d.a: error: it was given up"));
  EXPECT_LT(module_of(with("stop-device"), "b")["cycles"], 100);
}

TEST(Simulation, AfterACrashTheHostReturnsWithoutTheCrashedModule) {
  const Outcome run = Cell::of("<device name=\"d\">" + thread("a", "1000000") + thread("b", "1000000") +
                               program("p", "1000000") + "</device>")
                          .run({.length = milliseconds{300}}, "at 100 ms d.a crash");
  EXPECT_THAT(steps_of(run, "d.a"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT"));
  EXPECT_THAT(steps_of(run, "d.b"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "DESTRUCT", "IDLE", "INITIALIZE",
                                   "START", "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(steps_of(run, "d.p"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"));
  EXPECT_GT(module_of(run, "b")["cycles"], 200);
}

TEST(Simulation, RestartsAProgramThatCrashes) {
  const Outcome run =
      Cell::of("<device name=\"d\">" +
               program("p", "1000000", "<recovery attempts=\"3\" backoff=\"1000000\" then=\"destruct\"/>") +
               "</device>")
          .run({.length = milliseconds{200}}, "at 50 ms d.p crash");
  EXPECT_THAT(steps_of(run, "d.p"), testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER",
                                                         "EXECUTING", "START", "DESTRUCT"));
}

TEST(Simulation, DetectsARunThatHangs) {
  const Cell cell =
      Cell::of("<device name=\"d\">" + thread("a", "1000000") + program("p", "1000000") + "</device>");
  const Outcome run = cell.run({.length = seconds{3}}, "at 50 ms d.a hang\nat 60 ms d.p hang");
  EXPECT_THAT(steps_of(run, "d.a"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT"));
  EXPECT_THAT(run.lines, Contains(HasSubstr("hang (run() did not return")));
  EXPECT_THAT(run.lines, Contains(HasSubstr("hang (the process did not return to waitPeriod()")));
}

/// Returns a cell with executor `motion` in its own host and executor `main` in the shared host. Each
/// executor runs a thread module every millisecond.
Cell two_hosts(const std::string& recovery) {
  return Cell::of(R"(<device name="d"><executor name="main"/><executor name="motion" host="own"/>)" +
                  thread("a", "1000000", "<executor>motion</executor>" + recovery) +
                  thread("b", "1000000", "<executor>main</executor>") + "</device>");
}

TEST(Simulation, ACrashInAnExecutorsOwnHostStopsNothingElse) {
  const Outcome run =
      two_hosts("<recovery attempts=\"3\" backoff=\"1000000\" then=\"destruct\"/>")
          .run({.length = milliseconds{300}}, "at 100 ms d.a crash\nat 100 ms d.a unmended 1");
  EXPECT_THAT(steps_of(run, "d.a"), testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER",
                                                         "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(run.lines, Contains(HasSubstr("d.a recovery, attempt 2 of 3")));
  EXPECT_EQ(300, module_of(run, "b")["cycles"]);
  EXPECT_THAT(steps_of(run, "d.b"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"));
}

TEST(Simulation, AModuleThatRepeatedlyCrashesItsHostIsGivenUp) {
  std::string crashes;
  for (int ms = 50; ms < 500; ++ms) crashes += "at " + std::to_string(ms) + " ms d.a crash\n";
  const Outcome run = two_hosts("<recovery attempts=\"2\" backoff=\"0\" then=\"destruct\"/>")
                          .run({.length = milliseconds{500}}, crashes);
  EXPECT_EQ("DESTRUCT", steps_of(run, "d.a").back());
  EXPECT_THAT(to_text(run.course.failures), HasSubstr("module d.a: error: it was given up"));
  EXPECT_EQ(500, module_of(run, "b")["cycles"]);
}

TEST(Simulation, RejectsCommandsThatTheStateDoesNotAllow) {
  const Outcome run =
      Cell::of("<device name=\"d\">" + thread("a", "1000000") + program("p", "1000000") + "</device>")
          .run({.length = milliseconds{400}},
               "at 50 ms d.a stop\nat 60 ms d.a reset\nat 100 ms d.a start\n"
               "at 150 ms d.a destruct\nat 200 ms d.a reset\nat 250 ms d.a initialize\n"
               "at 300 ms d.a start\nat 350 ms d.a swap\nat 100 ms d.p stop\nat 200 ms d.p start");
  EXPECT_THAT(
      steps_of(run, "d.a"),
      testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "START", "EXECUTING", "START", "DESTRUCT",
                           "IDLE", "INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(run.lines, Contains(HasSubstr("reset: reset is not allowed in state START")));
  EXPECT_THAT(run.lines, Contains(HasSubstr("d.a command (swap: done)")));
  EXPECT_THAT(steps_of(run, "d.p"), testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "START",
                                                         "EXECUTING", "START", "DESTRUCT"));
}

// When the start command arrives, the executor has already removed the failed module from the tables, but the
// supervisor has not yet seen the error.
TEST(Simulation, AStartCommandDoesNotPutAFailedModuleBackIntoTheTables) {
  const Outcome run =
      Cell::of("<device name=\"d\">" + thread("a", "100000000", "<recovery attempts=\"3\" backoff=\"0\"/>") +
               "</device>")
          .run({.length = milliseconds{150}}, "at 0 ms d.a fail\nat 9 ms d.a start\nat 9 ms d.a unmended 9");
  EXPECT_THAT(steps_of(run, "d.a"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT"));
}

TEST(Simulation, ReadersGetTheSafeValueWhileTheWriterDoesNotExecute) {
  const auto with = [](const std::string& to) {
    return Cell::of(
               "<device name=\"d\">" +
               thread("w", "1000000", R"(<safe><port name="out"><field name="x">0</field></port></safe>)") +
               thread("r", "1000000") + "</device><device name=\"e\">" + thread("r", "1000000") +
               "</device><connection from=\"d.w.out\" to=\"" + to + "\" kind=\"latest\"/>")
        .run({.length = milliseconds{300}}, "at 100 ms d.w stop\nat 200 ms d.w start");
  };
  for (const std::string reader : {"d.r.in", "e.r.in"}) {
    const Outcome run = with(reader);
    std::vector<std::string> seen;
    for (const std::string& line : run.lines) {
      if (line.find("safe value") != std::string::npos ||
          line.find("gives its reader samples again") != std::string::npos)
        seen.push_back(line.substr(line.find(' ') + 1));
    }
    const std::string safe = reader + " gives its reader the safe value";
    const std::string again = reader + " gives its reader samples again";
    ASSERT_GE(seen.size(), 2U) << reader;
    EXPECT_THAT(std::vector(seen.end() - 2, seen.end()), testing::ElementsAre(safe, again));
  }
}

/// Returns a cell of two devices, a and b. Module b.r reads the output of a.w.
Cell pair(const std::string& connection) {
  return Cell::of(
      "<device name=\"a\">" + thread("w", "1000000") + "</device><device name=\"b\">" +
      thread("r", "1000000", "<recovery attempts=\"100\" backoff=\"1000000\" then=\"destruct\"/>") +
      "</device><connection from=\"a.w.out\" to=\"b.r.in\" " + connection + "/>");
}

TEST(Simulation, ACutBetweenDevicesMakesValuesStale) {
  const Outcome run = pair(R"(kind="latest" deadline="10000000" stale="error")")
                          .run({.length = milliseconds{500}}, "at 100 ms link a b cut for 200 ms");
  EXPECT_THAT(steps_of(run, "b.r"), testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER",
                                                         "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(run.lines, Contains(HasSubstr("EXECUTING -> RECOVER, step 4, stale")));
}

TEST(Simulation, AModuleRecoversFromMoreStaleInputsThanItHasAttempts) {
  const Outcome run =
      Cell::of("<device name=\"a\">" + thread("w", "1000000") + "</device><device name=\"b\">" +
               thread("r", "1000000", "<recovery attempts=\"1\" backoff=\"1000000\" then=\"destruct\"/>") +
               "</device><connection from=\"a.w.out\" to=\"b.r.in\" deadline=\"10ms\" stale=\"error\"/>")
          .run({.length = milliseconds{500}},
               "at 100 ms link a b cut for 50 ms\nat 200 ms link a b cut for 50 ms\n"
               "at 300 ms link a b cut for 50 ms");
  EXPECT_THAT(steps_of(run, "b.r"),
              testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "RECOVER", "EXECUTING", "RECOVER",
                                   "EXECUTING", "RECOVER", "EXECUTING", "START", "DESTRUCT"));
  EXPECT_THAT(run.lines, Contains(HasSubstr("b.r recovery, because the value of its input is fresh again")));
}

TEST(Simulation, ACutBetweenDevicesDelaysReliableSamplesAndLosesOthers) {
  const std::string cut = "at 100 ms link a b cut for 20 ms";
  const auto lost = [](const Outcome& run) {
    return std::count_if(run.lines.begin(), run.lines.end(),
                         [](const std::string& line) { return line.ends_with("is lost"); });
  };
  const Outcome kept = pair(R"(kind="queue" depth="50")").run({.length = milliseconds{300}}, cut);
  EXPECT_EQ(0, lost(kept));
  EXPECT_GE(module_of(kept, "r")["ports"][0]["samples"], 298);
  EXPECT_THAT(lost(pair(R"(kind="latest")").run({.length = milliseconds{300}}, cut)),
              testing::AllOf(testing::Ge(19), testing::Le(21)));
}

TEST(Simulation, LosesAndDelaysTheSamplesNamedInTheScript) {
  const Outcome run =
      pair(R"(kind="latest")")
          .run({.length = milliseconds{100}},
               "at 20.5 ms connection a.w.out lose 3\nat 40.5 ms connection a.w.out late 5 ms");
  EXPECT_EQ(3, module_of(run, "r")["ports"][0]["lost"]);
  for (const char* number : {"22", "23", "24"})
    EXPECT_THAT(run.lines, Contains(HasSubstr("b.r.in " + std::string{number} + " is lost")));
  const auto when = [&run](const std::string& what) {
    for (const std::string& line : run.lines) {
      if (line.ends_with(what)) return std::stod(line);
    }
    return 0.0;
  };
  EXPECT_GT(when("b.r.in 42 arrived"), 0.046);
  EXPECT_LT(when("b.r.in 48 arrived"), 0.048);
}

TEST(Simulation, AClockStepMakesValuesStaleButDoesNotMoveTheGrid) {
  const Outcome run = pair(R"(kind="latest" deadline="10000000" stale="error")")
                          .run({.length = milliseconds{200}}, "at 100 ms b clock-step 50 ms");
  EXPECT_THAT(run.lines, Contains(HasSubstr("EXECUTING -> RECOVER, step 4, stale")));
  EXPECT_EQ(0, run.course.report["devices"][1]["executors"][0]["missed"]);
}

TEST(Simulation, ALowerPriorityExecutorWaitsForAHigherPriorityOneOnASharedCpu) {
  const std::string modules =
      "<executor name=\"high\" priority=\"80\" cpu=\"0\"/><executor name=\"low\" priority=\"70\" cpu=\"";
  const auto with = [&](const std::string& cpu) {
    return Cell::of("<device name=\"d\">" + modules + cpu + "\"/>" +
                    thread("h", "1000000", "<executor>high</executor><budget>900000</budget>") +
                    thread("l", "1000000", "<executor>low</executor>") + "</device>")
        .run({.length = milliseconds{200}});
  };
  const double apart = module_of(with("1"), "l")["run_us"]["p50"];
  const double shared = module_of(with("0"), "l")["jitter_us"]["p99"];
  EXPECT_LT(apart, 300);
  EXPECT_GT(shared, 300);  // executor low is sometimes due while high is running
}

TEST(Simulation, TakesRunTimesFromTheProfile) {
  const Cell cell = Cell::of("<device name=\"d\">" + thread("a", "1000000") + "</device>");
  const auto us = [](int n) { return Nanoseconds{std::chrono::microseconds{n}}; };
  model::Profile profile{.cell = "c", .modules = {}};
  profile.modules["d.a"] = {
      .runs = 100, .min = us(400), .p50 = us(450), .p99 = us(500), .p999 = us(510), .max = us(520)};
  const Outcome run = cell.run({.length = seconds{2}, .profile = profile});
  const auto& measured = module_of(run, "a")["run_us"];
  EXPECT_GE(measured["min"], 400);
  EXPECT_LE(measured["max"], 520);
  EXPECT_NEAR(450, measured["p50"].get<double>(), 10);
}

constexpr std::uint64_t kSlower = kSanitized ? 20 : 1;  // with sanitizers, a run takes many times as long
constexpr std::uint64_t kParts = 16;
/// Returns the number of seeds to try: `full` in tools/test --full, otherwise an eighth of it, and less with
/// sanitizers.
std::uint64_t seeds(std::uint64_t full) { return std::max(kParts, full / kSlower / (full_form() ? 1 : 8)); }
/// Simulates random cells and the demo with all kinds of faults. No run may violate an invariant.
class RandomRuns : public testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomRuns, OfRandomCellsViolateNoInvariant) {
  for (std::uint64_t seed = GetParam(); seed < seeds(4000); seed += kParts) {
    const RandomCell random = random_cell(seed);
    const auto course = simulate(random.cell, random.plans, {}, random.options);
    ASSERT_TRUE(course.ok()) << to_text(course.problems());
    ASSERT_THAT(course->violations, IsEmpty())
        << "to see it: takt simulate --random-cell " << seed << " --trace -";
  }
}

TEST_P(RandomRuns, OfTheDemoViolateNoInvariant) {
  auto cell = descriptor::load(source_path("deploy/palletizing.xml"));
  const auto plans = schedule::plan(*cell);
  for (std::uint64_t seed = GetParam(); seed < seeds(320); seed += kParts) {
    const auto course = simulate(
        *cell, *plans, {},
        {.seed = seed, .length = milliseconds{200}, .faults_per_second = static_cast<double>(seed % 50)});
    ASSERT_TRUE(course.ok()) << to_text(course.problems());
    ASSERT_THAT(course->violations, IsEmpty())
        << "to see it: takt simulate deploy/palletizing.xml --for 0.2 --faults " << seed % 50 << " --seed "
        << seed << " --trace -";
  }
}

INSTANTIATE_TEST_SUITE_P(Simulation, RandomRuns, testing::Range(std::uint64_t{0}, kParts));

}  // namespace
}  // namespace takt::simulation::simulation_test
