// Simulates every fault at every point, and every command in every state. Compares the results with rules
// that this test states independently of the product. A simulation of several seconds takes milliseconds,
// because its time is virtual.
#include <map>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include <full_form.hpp>
#include "simulated.hpp"

namespace takt::simulation::matrix_test {
namespace {

using simulated::Cell;
using simulated::module_of;
using simulated::Outcome;
using simulated::program;
using simulated::steps_of;
using simulated::thread;
using std::chrono::seconds;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

enum class Kind { shared, own, process };
constexpr std::array kKinds{Kind::shared, Kind::own, Kind::process};
const char* to_text(Kind kind) {
  return kind == Kind::shared ? "thread module in the shared host"
         : kind == Kind::own  ? "thread module in a host of its own"
                              : "process module";
}

struct Recovery {
  int attempts = 3;
  std::string then = "destruct";
  std::string backoff = "10000000";
};

const std::string kPeriod = "10000000";

/// Selects the cases that a test tries. With sanitizers, a simulation takes many times as long, so the short
/// form tries only every seventh case.
class Sample {
 public:
  [[nodiscard]] bool leaves_out() { return kSanitized && !full_form() && tried_++ % 7 != 0; }

 private:
  int tried_ = 0;
};

/// Returns a cell with module d.m of this kind, and with neighbours that faults of d.m must not affect: d.b
/// in the shared host, d.c in its own host, process module d.q, and e.x on another device.
Cell cell_with(Kind kind, const Recovery& recovery = {}, const std::string& budget = "") {
  const std::string policy = "<recovery attempts=\"" + std::to_string(recovery.attempts) + "\" backoff=\"" +
                             recovery.backoff + "\" then=\"" + recovery.then + "\"/>";
  const std::string executor = kind == Kind::own ? "apart" : "main";
  const std::string m = kind == Kind::process
                            ? program("m", kPeriod, "<executor>main</executor>" + budget + policy)
                            : thread("m", kPeriod, "<executor>" + executor + "</executor>" + budget + policy);
  return Cell::of(R"(<device name="d"><executor name="main"/><executor name="apart" host="own"/>)"
                  R"(<executor name="other" host="own"/>)" +
                  m + thread("b", kPeriod, "<executor>main</executor>") +
                  thread("c", kPeriod, "<executor>other</executor>") +
                  program("q", kPeriod, "<executor>other</executor>") + "</device><device name=\"e\">" +
                  thread("x", kPeriod) + "</device>");
}

const std::vector<std::string> kUndisturbed{"INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"};

int attempts_in(const Outcome& run) {
  return static_cast<int>(std::count_if(run.lines.begin(), run.lines.end(), [](const std::string& line) {
    return line.find(" d.m recovery, attempt ") != std::string::npos;
  }));
}

struct Answer {
  std::string text = "no answer";
  std::string state;  ///< the state of d.m at the time of the answer
};

/// Returns the answer to the last command to d.m.
Answer answer_of(const Outcome& run) {
  Answer last;
  std::string state;
  for (const std::string& line : run.lines) {
    if (line.find(" d.m ") == std::string::npos) continue;
    if (const auto to = line.find(" -> "); to != std::string::npos)
      state = line.substr(to + 4, line.find(',', to) - to - 4);
    if (const auto text = line.find("d.m command ("); text != std::string::npos)
      last = {.text = line.substr(text + 13), .state = state};
  }
  return last;
}

/// Returns true if d.m cannot recover from this fault in run(), because the fault ends the host that d.m
/// shares with other modules.
bool is_fatal(Kind kind, const std::string& fault) { return kind == Kind::shared && fault != "fail"; }

TEST(RecoveryMatrix, AModuleIsGivenUpOnlyAfterAllItsRecoveryAttempts) {
  Sample sample;
  for (const Kind kind : kKinds) {
    for (const std::string fault : {"fail", "crash", "hang"}) {
      for (const int attempts : {0, 1, 3}) {
        for (const int unmended : {0, 1, 2, 3}) {
          if (sample.leaves_out()) continue;
          SCOPED_TRACE(std::string{to_text(kind)} + ", " + fault + ", " + std::to_string(attempts) +
                       " attempts, " + std::to_string(unmended) + " of them fail");
          const std::string script =
              "at 100 ms d.m " + fault +
              (unmended == 0 ? "" : "\nat 100 ms d.m unmended " + std::to_string(unmended));
          const Outcome run = cell_with(kind, {.attempts = attempts}).run({.length = seconds{3}}, script);
          const bool given_up = is_fatal(kind, fault) || unmended >= attempts;
          const std::vector<std::string> after =
              given_up ? std::vector<std::string>{"INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT"}
                       : std::vector<std::string>{"INITIALIZE", "START", "EXECUTING", "RECOVER",
                                                  "EXECUTING",  "START", "DESTRUCT"};
          EXPECT_EQ(after, steps_of(run, "d.m"));
          EXPECT_EQ(1, module_of(run, "m")["errors"]);
          EXPECT_EQ(is_fatal(kind, fault) ? 0 : std::min(attempts, unmended + 1), attempts_in(run));
          EXPECT_EQ(given_up ? 1U : 0U, run.course.failures.size()) << takt::to_text(run.course.failures);

          // When a host ends, all its modules end with it. The node reloads the modules that had no fault.
          if (is_fatal(kind, fault)) {
            EXPECT_THAT(steps_of(run, "d.b"),
                        testing::ElementsAre("INITIALIZE", "START", "EXECUTING", "DESTRUCT", "IDLE",
                                             "INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"));
          } else {
            EXPECT_EQ(kUndisturbed, steps_of(run, "d.b"));
          }
          for (const char* neighbour : {"d.c", "d.q", "e.x"})
            EXPECT_EQ(kUndisturbed, steps_of(run, neighbour)) << neighbour;
          for (const char* neighbour : {"c", "q", "x"})
            EXPECT_EQ(300, module_of(run, neighbour)["cycles"]) << neighbour;
        }
      }
    }
  }
}

TEST(RecoveryMatrix, GivingUpAModuleStopsTheDeviceOrCellIfTheDescriptorSaysSo) {
  Sample sample;
  for (const Kind kind : kKinds) {
    for (const std::string fault : {"fail", "crash", "hang"}) {
      for (const std::string then : {"destruct", "stop-device", "stop-cell"}) {
        if (sample.leaves_out()) continue;
        SCOPED_TRACE(std::string{to_text(kind)} + ", " + fault + ", " + then);
        const Outcome run = cell_with(kind, {.attempts = 0, .then = then})
                                .run({.length = seconds{5}}, "at 100 ms d.m " + fault);
        const int full = 500;
        const int stopped = 200;  // the node detects a hang after 1.1 s
        const auto cycles = [&](const char* module) { return module_of(run, module)["cycles"].get<int>(); };
        EXPECT_EQ("DESTRUCT", steps_of(run, "d.m").back());
        for (const char* neighbour : {"c", "q"}) {
          if (then == "destruct") {
            EXPECT_EQ(full, cycles(neighbour)) << neighbour;
          } else {
            EXPECT_LT(cycles(neighbour), stopped) << neighbour;
          }
        }
        if (then == "stop-cell") {
          EXPECT_LT(cycles("x"), stopped);
        } else {
          EXPECT_EQ(full, cycles("x"));
        }
      }
    }
  }
}

/// Returns the time since T0 of the first line about d.m that contains this text, in ms; -1 if there is none.
double ms_of(const Outcome& run, const std::string& text) {
  for (const std::string& line : run.lines) {
    if (line.find(" d.m ") != std::string::npos && line.find(text) != std::string::npos)
      return std::stod(line) * 1e3;
  }
  return -1;
}

/// Returns true if a line about d.m contains this text.
bool has_line(const Outcome& run, const std::string& text) { return ms_of(run, text) >= 0; }

TEST(RecoveryMatrix, AHangIsDetectedAtTheHangLimitThatTheBudgetImplies) {
  Sample sample;
  struct Limit {
    std::string budget;
    double thread_ms;
    double process_ms;
  };
  const std::vector<Limit> limits{
      {"", 1100, 1100},
      {"<budget>300000</budget>", 20, 1100},
      {"<budget>3000000</budget>", 30, 1100},
      {"<budget times=\"50\">3000000</budget>", 150, 1100},
      {"<budget in-a-row=\"5\">3000000</budget>", 30, 1100},
      {"<budget hang=\"400000000\">300000</budget>", 400, 400},
      {"<budget hang=\"7000000\">300000</budget>", 7, 7},
  };
  // The node checks the runs every 5 ms, and needs three checks to detect a hang. Then the process takes up
  // to 5 ms to end.
  constexpr double kDetected = 20;
  for (const Kind kind : kKinds) {
    for (const Limit& limit : limits) {
      if (sample.leaves_out()) continue;
      SCOPED_TRACE(std::string{to_text(kind)} + ", " + limit.budget);
      const Outcome run = cell_with(kind, {}, limit.budget).run({.length = seconds{3}}, "at 95 ms d.m hang");
      const double expected = kind == Kind::process ? limit.process_ms : limit.thread_ms;
      const double hung = ms_of(run, "RECOVER") - 100;
      EXPECT_GE(hung, expected);
      EXPECT_LE(hung, expected + kDetected);
      for (const char* neighbour : {"c", "q", "x"})
        EXPECT_EQ(300, module_of(run, neighbour)["cycles"]) << neighbour;
    }
  }
}

TEST(RecoveryMatrix, ARunThatEndsBeforeItsHangLimitIsOnlyABudgetError) {
  Sample sample;
  for (const Kind kind : {Kind::shared, Kind::own}) {
    if (sample.leaves_out()) continue;
    SCOPED_TRACE(to_text(kind));
    const Outcome run =
        cell_with(kind, {}, "<budget>300000</budget>").run({.length = seconds{1}}, "at 95 ms d.m late 19 ms");
    const std::vector<std::string> steps{"INITIALIZE", "START", "EXECUTING", "RECOVER",
                                         "EXECUTING",  "START", "DESTRUCT"};
    EXPECT_EQ(steps, steps_of(run, "d.m"));
    EXPECT_EQ(kUndisturbed, steps_of(run, "d.b"));
    EXPECT_THAT(run.course.failures, IsEmpty());
  }
}

TEST(RecoveryMatrix, AnExecutorThatRunsNoRowsIsInErrorAfterOneSecondPlusTenPeriods) {
  const Outcome run = cell_with(Kind::shared).run({.length = seconds{3}}, "at 95 ms d.main oversleep 10 s");
  const std::vector<std::string> reloaded{"INITIALIZE", "START", "EXECUTING", "DESTRUCT", "IDLE",
                                          "INITIALIZE", "START", "EXECUTING", "START",    "DESTRUCT"};
  for (const char* module : {"d.m", "d.b"}) EXPECT_EQ(reloaded, steps_of(run, module)) << module;
  EXPECT_GE(ms_of(run, "DESTRUCT"), 1190);
  EXPECT_LE(ms_of(run, "DESTRUCT"), 1220);
  for (const char* neighbour : {"c", "q", "x"})
    EXPECT_EQ(300, module_of(run, neighbour)["cycles"]) << neighbour;
}

TEST(RecoveryMatrix, AnExecutorThatOversleepsForLessThanASecondOnlyMissesRows) {
  const Outcome run = cell_with(Kind::shared).run({.length = seconds{3}}, "at 95 ms d.main oversleep 900 ms");
  EXPECT_EQ(kUndisturbed, steps_of(run, "d.m"));
  EXPECT_LT(module_of(run, "m")["cycles"], 250);
}

// A module of a higher priority keeps the CPU busy with runs of about 10 ms, so no run lasts suspiciously
// long. In the real cell, this module may belong to another device on the same machine.
TEST(RecoveryMatrix, AnExecutorThatGetsNoCpuTimeIsNotInError) {
  const Cell cell = Cell::of(R"(<device name="d"><executor name="busy" cpu="0" priority="80"/>)"
                             R"(<executor name="starved" cpu="0" priority="10" host="own"/>)" +
                             thread("a", kPeriod, "<executor>busy</executor>") +
                             thread("m", "4000000", "<executor>starved</executor>") +
                             program("q", "4000000", "<executor>starved</executor>") + "</device>");
  std::string script;
  for (int ms = 95; ms < 2600; ms += 10) script += "at " + std::to_string(ms) + " ms d.a late 9900 us\n";
  const Outcome run = cell.run({.length = seconds{3}}, script);
  for (const char* module : {"d.a", "d.m", "d.q"}) EXPECT_EQ(kUndisturbed, steps_of(run, module)) << module;
  EXPECT_LT(module_of(run, "m")["cycles"], 200) << "the executor had the CPU for about half a second";
  EXPECT_GT(module_of(run, "m")["cycles"], 50);
}

// Row 1 of each four rows is always missed, because a run in row 0 lasts until row 2.
TEST(RecoveryMatrix, AModuleWhoseRowsAreAlwaysMissedIsInError) {
  const Cell cell = Cell::of(
      R"(<device name="d"><executor name="main"/>)" + thread("a", "40000000", "<executor>main</executor>") +
      thread("m", "40000000", "<executor>main</executor><offset>10000000</offset>") + "</device>");
  std::string script;
  for (int ms = 195; ms < 2000; ms += 40) script += "at " + std::to_string(ms) + " ms d.a late 24 ms\n";
  const Outcome run = cell.run({.length = seconds{2}}, script);
  EXPECT_EQ(kUndisturbed, steps_of(run, "d.a"));
  const std::vector<std::string> recovered{"INITIALIZE", "START", "EXECUTING", "RECOVER",
                                           "EXECUTING",  "START", "DESTRUCT"};
  EXPECT_EQ(recovered, steps_of(run, "d.m"));
  EXPECT_TRUE(has_line(run, "the executor has not called it for 1.4 s"));
  EXPECT_EQ(1, module_of(run, "m")["errors"]);
}

TEST(CommandMatrix, StartFailsIfTheExecutorRunsNoRows) {
  const Outcome run = cell_with(Kind::own).run({.length = seconds{3}},
                                               "at 50 ms d.m stop\nat 95 ms d.apart oversleep 10 s\n"
                                               "at 150 ms d.m start");
  EXPECT_THAT(answer_of(run).text, HasSubstr("start: executor apart ran no row for 1.1 s, so the node killed "
                                             "the host of executor apart"));
}

/// A fault in a hook of d.m, and the states that d.m then goes through if it has this kind of host.
struct InHook {
  std::string hook;
  std::string before;  ///< the script that makes the host call the hook
  std::string fault;
  Kind kind;
  std::vector<std::string> after;  ///< the states that follow EXECUTING
};

TEST(RecoveryMatrix, AModuleRecoversFromAFaultInAHookIfItsInstanceCanBeReplaced) {
  Sample sample;
  const std::string error = "at 100 ms d.m fail\n";
  // The module is either given up, or recovers and is stopped at the end of the simulation.
  const std::vector<std::string> lost{"RECOVER", "DESTRUCT"};
  const std::vector<std::string> recovered{"RECOVER", "EXECUTING", "START", "DESTRUCT"};
  const std::vector<InHook> cases{
      // error() only informs the module, so its failure changes nothing.
      {"error", error, "fail", Kind::shared, recovered},
      {"error", error, "fail", Kind::own, recovered},
      {"recover", error, "fail", Kind::shared, recovered},
      {"recover", error, "fail", Kind::own, recovered},
      // A crash destroys the instance. The node replaces it only if the module has its own host.
      {"error", error, "crash", Kind::shared, lost},
      {"error", error, "crash", Kind::own, recovered},
      {"recover", error, "crash", Kind::shared, lost},
      {"recover", error, "crash", Kind::own, recovered},
      // A hook that hangs never returns, so the node cannot replace the instance.
      {"error", error, "hang", Kind::shared, lost},
      {"error", error, "hang", Kind::own, lost},
      {"recover", error, "hang", Kind::shared, lost},
      {"recover", error, "hang", Kind::own, lost},
  };
  for (const InHook& each : cases) {
    if (sample.leaves_out()) continue;
    SCOPED_TRACE(std::string{to_text(each.kind)} + ", " + each.fault + " in " + each.hook);
    const Outcome run = cell_with(each.kind).run(
        {.length = seconds{7}}, each.before + "at 0 ms d.m " + each.fault + " in " + each.hook);
    std::vector<std::string> expected{"INITIALIZE", "START", "EXECUTING"};
    expected.insert(expected.end(), each.after.begin(), each.after.end());
    EXPECT_EQ(expected, steps_of(run, "d.m"));
    EXPECT_EQ(each.after == lost, !run.course.failures.empty());
    EXPECT_EQ(each.fault == "crash" ? 2 : 1, module_of(run, "m")["errors"]);
    for (const char* neighbour : {"c", "q", "x"})
      EXPECT_EQ(700, module_of(run, neighbour)["cycles"]) << neighbour;
    if (each.kind == Kind::own || each.fault != "crash") {
      EXPECT_EQ(kUndisturbed, steps_of(run, "d.b"));
    }
  }
}

TEST(RecoveryMatrix, AFaultInAHookThatACommandCallsLeadsToRecoverOrDestruct) {
  Sample sample;
  using Steps = std::vector<std::string>;
  // A module can recover only after its initialize() has succeeded. After a reset, there is no initialized
  // module that could recover.
  const Steps no_reset{};
  const Steps not_initialised{"IDLE", "DESTRUCT"};
  const Steps not_started{"IDLE", "INITIALIZE", "RECOVER", "DESTRUCT"};
  const Steps recovered{"IDLE", "INITIALIZE", "RECOVER", "START", "EXECUTING", "START", "DESTRUCT"};
  for (const Kind kind : {Kind::shared, Kind::own}) {
    for (const std::string hook : {"load", "initialize", "start"}) {
      for (const std::string fault : {"fail", "crash", "hang"}) {
        if (sample.leaves_out()) continue;
        SCOPED_TRACE(std::string{to_text(kind)} + ", " + fault + " in " + hook);
        const Outcome run = cell_with(kind).run(
            {.length = seconds{9}}, "at 100 ms d.m destruct\nat 200 ms d.m " + fault + " in " + hook +
                                        "\nat 300 ms d.m reset\nat 500 ms d.m initialize\n"
                                        "at 700 ms d.m start");
        const bool mends = fault == "fail" || (fault == "crash" && kind == Kind::own);
        const Steps expected = hook == "load"         ? no_reset
                               : hook == "initialize" ? not_initialised
                               : mends                ? recovered
                                                      : not_started;
        const Steps before{"INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"};
        Steps all = before;
        all.insert(all.end(), expected.begin(), expected.end());
        EXPECT_EQ(all, steps_of(run, "d.m"));
        const bool no_step = fault == "crash" && hook != "start";  // the crash occurs before INITIALIZE
        EXPECT_EQ(std::count(all.begin(), all.end(), "RECOVER") + (no_step ? 1 : 0),
                  module_of(run, "m")["errors"]);
        for (const char* neighbour : {"c", "q", "x"})
          EXPECT_EQ(900, module_of(run, neighbour)["cycles"]) << neighbour;
      }
    }
  }
}

// If destruct() of a module fails, crashes or hangs, the module ends in DESTRUCT all the same, without
// recovery.
TEST(RecoveryMatrix, AFaultInTheDestructHookStillEndsInDestruct) {
  Sample sample;
  for (const Kind kind : {Kind::shared, Kind::own}) {
    for (const std::string fault : {"fail", "crash", "hang"}) {
      if (sample.leaves_out()) continue;
      SCOPED_TRACE(std::string{to_text(kind)} + ", " + fault);
      const Outcome run = cell_with(kind).run(
          {.length = seconds{7}}, "at 100 ms d.m " + fault + " in destruct\nat 200 ms d.m destruct");
      EXPECT_EQ("DESTRUCT", steps_of(run, "d.m").back());
      EXPECT_THAT(steps_of(run, "d.m"), testing::SizeIs(fault == "fail" ? 5 : 6));
      EXPECT_EQ(fault == "fail", run.course.failures.empty());
      EXPECT_THAT(answer_of(run).text, HasSubstr("destruct: done"));
      for (const char* neighbour : {"c", "q", "x"})
        EXPECT_EQ(700, module_of(run, neighbour)["cycles"]) << neighbour;
    }
  }
}

TEST(RecoveryMatrix, ModulesThatCrashOneAfterTheOtherAreRemovedOneByOne) {
  const Outcome run = Cell::of("<device name=\"d\">" + thread("a", kPeriod) + thread("b", kPeriod) +
                               thread("c", kPeriod) + "</device>")
                          .run({.length = seconds{1}}, "at 100 ms d.a crash\nat 300 ms d.b crash");
  const std::vector<std::string> back{"DESTRUCT", "IDLE", "INITIALIZE", "START", "EXECUTING"};
  std::vector<std::string> steps{"INITIALIZE", "START", "EXECUTING"};
  const auto with = [](std::vector<std::string> all, const std::vector<std::string>& more) {
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  EXPECT_EQ(with(steps, {"RECOVER", "DESTRUCT"}), steps_of(run, "d.a"));
  EXPECT_EQ(with(with(steps, back), {"RECOVER", "DESTRUCT"}), steps_of(run, "d.b"));
  EXPECT_EQ(with(with(with(steps, back), back), {"START", "DESTRUCT"}), steps_of(run, "d.c"));
  EXPECT_EQ(2U, run.course.failures.size());
}

TEST(FinishMatrix, AModuleThatFinishesGoesToDestructWithoutARecovery) {
  Sample sample;
  for (const Kind kind : kKinds) {
    for (const std::string then : {"destruct", "stop-device", "stop-cell"}) {
      if (sample.leaves_out()) continue;
      SCOPED_TRACE(std::string{to_text(kind)} + ", " + then);
      const Outcome run = cell_with(kind, {.then = then}).run({.length = seconds{1}}, "at 105 ms d.m finish");
      EXPECT_EQ(kUndisturbed, steps_of(run, "d.m"));
      EXPECT_TRUE(has_line(run, "it has finished"));
      EXPECT_EQ(12, module_of(run, "m")["cycles"]) << "the run at 110 ms is the last one";
      EXPECT_EQ(0, module_of(run, "m")["errors"]);
      EXPECT_EQ("it has finished", module_of(run, "m")["text"]);
      EXPECT_EQ(0, attempts_in(run));
      EXPECT_THAT(run.course.failures, IsEmpty());
      for (const char* neighbour : {"d.b", "d.c", "d.q", "e.x"})
        EXPECT_EQ(kUndisturbed, steps_of(run, neighbour)) << neighbour;
      for (const char* neighbour : {"b", "c", "q", "x"})
        EXPECT_EQ(100, module_of(run, neighbour)["cycles"]) << neighbour;
    }
  }
}

TEST(FinishMatrix, AModuleMayFinishInItsFirstRunOrAfterARecovery) {
  Sample sample;
  const std::vector<std::string> after_recovery{"INITIALIZE", "START", "EXECUTING", "RECOVER",
                                                "EXECUTING",  "START", "DESTRUCT"};
  for (const Kind kind : kKinds) {
    if (sample.leaves_out()) continue;
    SCOPED_TRACE(to_text(kind));
    const Outcome first = cell_with(kind).run({.length = seconds{1}}, "at 0 ms d.m finish");
    EXPECT_EQ(kUndisturbed, steps_of(first, "d.m"));
    EXPECT_EQ(1, module_of(first, "m")["cycles"]);
    const Outcome later =
        cell_with(kind).run({.length = seconds{1}}, "at 100 ms d.m fail\nat 500 ms d.m finish");
    EXPECT_EQ(after_recovery, steps_of(later, "d.m"));
    EXPECT_THAT(later.course.failures, IsEmpty());
  }
}

TEST(FinishMatrix, AModuleThatHasFinishedRunsAgainAfterAReset) {
  Sample sample;
  for (const Kind kind : kKinds) {
    if (sample.leaves_out()) continue;
    SCOPED_TRACE(to_text(kind));
    const Outcome run = cell_with(kind).run({.length = seconds{1}},
                                            "at 105 ms d.m finish\nat 300 ms d.m reset\n"
                                            "at 400 ms d.m initialize\nat 500 ms d.m start");
    const std::vector<std::string> steps{"INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT", "IDLE",
                                         "INITIALIZE", "START", "EXECUTING", "START", "DESTRUCT"};
    EXPECT_EQ(steps, steps_of(run, "d.m"));
    EXPECT_GT(module_of(run, "m")["cycles"], 55);
    EXPECT_THAT(answer_of(run).text, HasSubstr("start: done"));
  }
}

TEST(FinishMatrix, ACommandSentWhileAModuleFinishesIsAnswered) {
  Sample sample;
  for (const Kind kind : kKinds) {
    for (const std::string command : {"stop", "destruct", "start"}) {
      if (sample.leaves_out()) continue;
      SCOPED_TRACE(std::string{to_text(kind)} + ", " + command);
      // A module finishes at the end of a run, so the stopped module needs the start to finish.
      const std::string script = command == "start"
                                     ? "at 100 ms d.m stop\nat 200 ms d.m finish\nat 205 ms d.m start"
                                     : "at 105 ms d.m finish\nat 110 ms d.m " + command;
      const Outcome run = cell_with(kind).run({.length = seconds{1}}, script);
      EXPECT_EQ("DESTRUCT", steps_of(run, "d.m").back());
      EXPECT_THAT(answer_of(run).text, Not(HasSubstr("no answer")));
      EXPECT_THAT(run.course.failures, IsEmpty());
      if (command == "start") {
        EXPECT_THAT(answer_of(run).text, HasSubstr("start: done"));
      }
    }
  }
}

TEST(FinishMatrix, AModuleThatFinishesWhileItsHostEndsStaysInDestruct) {
  Sample sample;
  for (const char* fault : {"crash", "hang"}) {
    if (sample.leaves_out()) continue;
    SCOPED_TRACE(fault);
    // Module d.b runs after d.m, in the same row and in the same host.
    const Outcome run =
        cell_with(Kind::shared)
            .run({.length = seconds{3}}, std::string{"at 105 ms d.m finish\nat 105 ms d.b "} + fault);
    EXPECT_EQ("DESTRUCT", steps_of(run, "d.m").back());
    EXPECT_EQ(12, module_of(run, "m")["cycles"]);
    EXPECT_EQ(300, module_of(run, "c")["cycles"]);
  }
}

/// For each state, the script that brings d.m from EXECUTING to this state.
const std::map<std::string, std::string> kWayTo{
    {"EXECUTING", ""},
    {"START", "at 100 ms d.m stop\n"},
    {"DESTRUCT", "at 100 ms d.m destruct\n"},
    {"IDLE", "at 100 ms d.m destruct\nat 300 ms d.m reset\n"},
    {"INITIALIZE", "at 100 ms d.m destruct\nat 300 ms d.m reset\nat 500 ms d.m initialize\n"},
    {"RECOVER", "at 100 ms d.m crash\n"},
};

TEST(CommandMatrix, ACommandIsExecutedOnlyInTheStatesThatAllowIt) {
  Sample sample;
  const std::map<std::string, std::vector<std::string>> allowed{
      {"initialize", {"IDLE"}}, {"start", {"INITIALIZE", "START"}},
      {"stop", {"EXECUTING"}},  {"recover", {"RECOVER"}},
      {"reset", {"DESTRUCT"}},  {"destruct", {"IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER"}},
  };
  const std::map<std::string, std::string> leads_to{
      {"initialize", "INITIALIZE"}, {"start", "EXECUTING"}, {"stop", "START"},
      {"recover", "EXECUTING"},     {"reset", "IDLE"},      {"destruct", "DESTRUCT"}};
  for (const Kind kind : {Kind::own, Kind::process}) {
    for (const auto& [state, way] : kWayTo) {
      for (const auto& [command, states] : allowed) {
        if (sample.leaves_out()) continue;
        SCOPED_TRACE(std::string{to_text(kind)} + ", " + command + " in " + state);
        const bool may = std::find(states.begin(), states.end(), state) != states.end();
        // The backoff of 2 s keeps the module in RECOVER until the command arrives.
        const Cell cell = cell_with(kind, {.backoff = "2000000000"});
        const Outcome run = cell.run({.length = seconds{3}}, way + "at 1 s d.m " + command);
        const Answer answer = answer_of(run);
        if (!may) {
          EXPECT_THAT(answer.text, HasSubstr(command + " is not allowed in state " + state));
          if (state == "DESTRUCT" && (command == "start" || command == "recover")) {
            EXPECT_THAT(answer.text, HasSubstr("; run takt reset d.m first, or takt restart d.m"));
          }
          continue;
        }
        EXPECT_THAT(answer.text, HasSubstr(command + ": done"));
        EXPECT_EQ(leads_to.at(command), answer.state);
      }
    }
  }
}

TEST(SwapMatrix, AFaultOfTheNewInstanceFailsTheSwapButNotTheModule) {
  Sample sample;
  for (const Kind kind : {Kind::shared, Kind::own}) {
    for (const std::string hook : {"load", "initialize", "start"}) {
      for (const std::string fault : {"fail", "crash", "hang"}) {
        if (sample.leaves_out()) continue;
        SCOPED_TRACE(std::string{to_text(kind)} + ", " + fault + " in " + hook);
        const Outcome run = cell_with(kind).run(
            {.length = seconds{7}}, "at 100 ms d.m " + fault + " in " + hook + "\nat 200 ms d.m swap");
        EXPECT_THAT(answer_of(run).text, testing::AllOf(HasSubstr("swap: "), Not(HasSubstr("done"))));
        EXPECT_THAT(run.course.failures, IsEmpty());
        const std::vector<std::string> reloaded{"INITIALIZE", "START", "EXECUTING", "DESTRUCT", "IDLE",
                                                "INITIALIZE", "START", "EXECUTING", "START",    "DESTRUCT"};
        // A crash ends the host, and then the node reloads all modules of the host.
        EXPECT_EQ(fault == "crash" ? reloaded : kUndisturbed, steps_of(run, "d.m"));
        for (const char* neighbour : {"c", "q", "x"})
          EXPECT_EQ(700, module_of(run, neighbour)["cycles"]) << neighbour;
      }
    }
  }
}

}  // namespace
}  // namespace takt::simulation::matrix_test
