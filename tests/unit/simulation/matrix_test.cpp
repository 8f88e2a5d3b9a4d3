// Simulates every fault at every point, and every command in every state. Compares the results with rules
// that this test states independently of the product. Seconds of a cell take milliseconds on virtual time.
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

/// With sanitizers a cell takes many times as long, so the short form tries only every seventh one.
class Sample {
 public:
  [[nodiscard]] bool leaves_out() { return kSanitized && !full_form() && tried_++ % 7 != 0; }

 private:
  int tried_ = 0;
};

/// Returns a cell with module d.m of this kind, and with neighbours that its faults must not affect: d.b in
/// the shared host, d.c in its own host, program d.q, and e.x on another device.
Cell cell_with(Kind kind, const Recovery& recovery = {}) {
  const std::string policy = "<recovery attempts=\"" + std::to_string(recovery.attempts) + "\" backoff=\"" +
                             recovery.backoff + "\" then=\"" + recovery.then + "\"/>";
  const std::string executor = kind == Kind::own ? "apart" : "main";
  const std::string m = kind == Kind::process
                            ? program("m", kPeriod, "<executor>main</executor>" + policy)
                            : thread("m", kPeriod, "<executor>" + executor + "</executor>" + policy);
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
  std::string state;  ///< the state of the module at that time
};

/// Returns the answer to the last command.
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

/// Returns whether no recovery can follow a fault in run(). This is so if the fault ends the host that the
/// module shares with others.
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
          EXPECT_EQ(is_fatal(kind, fault) ? 0 : std::min(attempts, unmended + 1), attempts_in(run));
          EXPECT_EQ(given_up ? 1U : 0U, run.course.failures.size()) << takt::to_text(run.course.failures);

          // When a host ends, all its modules end with it. Those without a fault are loaded again.
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

TEST(RecoveryMatrix, GivingUpAModuleStopsWhatItsThenAttributeSays) {
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

/// A fault in a hook, the script that leads to the call of the hook, and the expected transitions in this
/// kind of host.
struct InHook {
  std::string hook;
  std::string before;  ///< the script that leads to the call
  std::string fault;
  Kind kind;
  std::vector<std::string> after;  ///< the states that follow EXECUTING
};

TEST(RecoveryMatrix, AModuleRecoversFromAFaultInAHookIfItsInstanceCanBeReplaced) {
  Sample sample;
  const std::string error = "at 100 ms d.m fail\n";
  // The module is either given up, or recovers and is shut down at the end.
  const std::vector<std::string> lost{"RECOVER", "DESTRUCT"};
  const std::vector<std::string> recovered{"RECOVER", "EXECUTING", "START", "DESTRUCT"};
  const std::vector<InHook> cases{
      // error() only informs the module, so its failure changes nothing.
      {"error", error, "fail", Kind::shared, recovered},
      {"error", error, "fail", Kind::own, recovered},
      {"recover", error, "fail", Kind::shared, recovered},
      {"recover", error, "fail", Kind::own, recovered},
      // A crash destroys the instance. In the shared host, it is not replaced.
      {"error", error, "crash", Kind::shared, lost},
      {"error", error, "crash", Kind::own, recovered},
      {"recover", error, "crash", Kind::shared, lost},
      {"recover", error, "crash", Kind::own, recovered},
      // A hook that hangs never returns, so its instance cannot be replaced.
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
    for (const char* neighbour : {"c", "q", "x"})
      EXPECT_EQ(700, module_of(run, neighbour)["cycles"]) << neighbour;
    if (each.kind == Kind::own || each.fault != "crash") {
      EXPECT_EQ(kUndisturbed, steps_of(run, "d.b"));
    }
  }
}

TEST(RecoveryMatrix, AFaultInAHookOfACommandLeadsToRecoverOrDestruct) {
  Sample sample;
  using Steps = std::vector<std::string>;
  // A module can recover only after initialize() has succeeded. After a reset alone there is nothing to
  // recover.
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
        for (const char* neighbour : {"c", "q", "x"})
          EXPECT_EQ(900, module_of(run, neighbour)["cycles"]) << neighbour;
      }
    }
  }
}

// A module whose destruct() fails ends in DESTRUCT all the same, without recovery.
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

/// For each state, the commands that bring a module there from EXECUTING.
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
        // The backoff keeps the module in RECOVER until the command arrives.
        const Cell cell = cell_with(kind, {.backoff = "2000000000"});
        const Outcome run = cell.run({.length = seconds{3}}, way + "at 1 s d.m " + command);
        const Answer answer = answer_of(run);
        if (!may) {
          EXPECT_THAT(answer.text, HasSubstr(command + " is not allowed in state " + state));
          continue;
        }
        EXPECT_THAT(answer.text, HasSubstr(command + ": done"));
        EXPECT_EQ(leads_to.at(command), answer.state);
      }
    }
  }
}

TEST(SwapMatrix, AFaultOfTheNewInstanceKeepsTheOldOneRunning) {
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
        // A crash ends the host, and then all its modules are loaded again.
        EXPECT_EQ(fault == "crash" ? reloaded : kUndisturbed, steps_of(run, "d.m"));
        for (const char* neighbour : {"c", "q", "x"})
          EXPECT_EQ(700, module_of(run, neighbour)["cycles"]) << neighbour;
      }
    }
  }
}

}  // namespace
}  // namespace takt::simulation::matrix_test
