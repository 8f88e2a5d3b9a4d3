// What the agents of a simulated cell do when its devices lose each other.
#include <gmock/gmock.h>

#include <string>

#include "simulated.hpp"

namespace takt::simulation::nodes_test {
namespace {

using simulated::Cell;
using simulated::module_of;
using simulated::Outcome;
using simulated::program;
using simulated::thread;
using std::chrono::milliseconds;
using testing::IsEmpty;
using testing::StartsWith;

/// A cell of the devices a, b and c, in which module m of device a stops the cell when it is given up.
Cell guarded() {
  return Cell::of("<device name=\"a\">" +
                  thread("m", "1000000", "<recovery attempts=\"0\" then=\"stop-cell\"/>") +
                  "</device><device name=\"b\">" + thread("m", "1000000") + "</device><device name=\"c\">" +
                  thread("m", "1000000") + "</device>");
}

TEST(Nodes, ADeviceThatHasLostAGuardedDeviceStops) {
  const Outcome run = guarded().run({.length = milliseconds{900}}, "at 100 ms link a b cut for 500 ms");
  ASSERT_EQ(run.course.failures.size(), 3U) << "b stops, and so does the cell";
  EXPECT_THAT(run.course.failures[1].where, "device a");
  EXPECT_THAT(run.course.failures[1].what,
              StartsWith("is lost, and one of its modules stops the cell when it fails"));
}

TEST(Nodes, AShortCutStopsNothing) {
  const Outcome run = guarded().run({.length = milliseconds{900}}, "at 100 ms link a b cut for 100 ms");
  EXPECT_THAT(run.course.failures, IsEmpty());
}

/// A cell of the devices a and b, whose modules have this period, in ns.
Cell pair(const std::string& period, const std::string& file) {
  return Cell::of("<device name=\"a\">" + thread("m", period) + "</device><device name=\"b\">" +
                      thread("m", period) + "</device>",
                  file);
}

/// Runs the cell with a script that may update it to twice its period. Returns the reports of the operator,
/// and then the descriptor that each device ran at the end.
std::string run_pair(const std::string& script, milliseconds length = milliseconds{3000}) {
  static const Cell cell = pair("10000000", "cell.xml");
  static const Version update = pair("20000000", "new.xml").version();
  const Outcome run = cell.run({.length = length, .update = &update}, script);
  std::string text;
  for (const Report& report : run.course.reports) text += to_text(report) + "; ";
  for (const auto& version : run.course.ran) text += version ? (*version == 0 ? "old " : "new ") : "none ";
  return text;
}

TEST(Nodes, AnUpdateIsMadeOnAllDevices) { EXPECT_EQ(run_pair("at 300 ms update"), "update: done; new new "); }

TEST(Nodes, AnUndeployedCellCanBeDeployedAgain) {
  EXPECT_EQ(run_pair("at 300 ms undeploy"), "undeploy: done; none none ");
  EXPECT_EQ(run_pair("at 300 ms undeploy\nat 400 ms deploy"), "undeploy: done; deploy: done; old old ");
}

TEST(Nodes, ADeviceThatLosesItsPowerRunsTheCellAgain) {
  EXPECT_EQ(run_pair("at 300 ms a down for 500 ms"), "old old ");
  EXPECT_EQ(run_pair("at 300 ms update\nat 1500 ms a down for 100 ms"), "update: done; new new ");
  EXPECT_EQ(run_pair("at 300 ms a down for 10 s"), "none old ");
}

TEST(Nodes, AnUpdateNeedsAllDevices) {
  EXPECT_EQ(run_pair("at 300 ms a down for 500 ms\nat 700 ms update"),
            "update: failed; the devices run what they ran before: device a: it is not found; old old ");
  EXPECT_EQ(run_pair("at 300 ms update\nat 320 ms a down for 500 ms", milliseconds{20000}),
            "update: failed; the devices run what they ran before: device a: no answer; old old ");
}

TEST(Nodes, APausedNodeLetsItsModulesRunOn) {
  const Outcome run =
      pair("10000000", "cell.xml").run({.length = milliseconds{2000}}, "at 300 ms a paused for 1 s");
  EXPECT_EQ(module_of(run, "m")["cycles"], 200);
}

/// Returns the time since T0, in s, of the first line that contains `text`; 0 if there is none.
double time_of(const Outcome& run, const std::string& text) {
  for (const std::string& line : run.lines) {
    if (line.find(text) != std::string::npos) return std::stod(line);
  }
  return 0;
}

TEST(Nodes, APausedNodeRecoversItsModulesAfterThePause) {
  const Outcome run =
      pair("10000000", "cell.xml")
          .run({.length = milliseconds{3000}}, "at 300 ms a paused for 1 s\nat 500 ms a.m fail");
  EXPECT_GE(time_of(run, "a.m EXECUTING -> RECOVER"), 1.3);
  EXPECT_GE(time_of(run, "a.m RECOVER -> EXECUTING"), 1.3);
}

TEST(Nodes, AnUpdateTakesLongerIfMessagesAreSlow) {
  const Version update = pair("20000000", "new.xml").version();
  const auto took = [&update](milliseconds delay) {
    const Outcome run = pair("10000000", "cell.xml")
                            .run({.length = milliseconds{3000}, .message_delay = delay, .update = &update},
                                 "at 300 ms update");
    return time_of(run, "update: done");
  };
  EXPECT_GT(took(milliseconds{80}), took(milliseconds{0}) + 0.03);
}

TEST(Nodes, ADeviceThatMissesAnUndeploymentEndsTheCellWhenItIsBack) {
  EXPECT_EQ(run_pair("at 300 ms a down for 2 s\nat 1 s undeploy", milliseconds{6000}),
            "undeploy: its outcome is not known: device a: it is lost; none none ");
}

TEST(Nodes, TheDevicesUndoAnUpdateIfTheOperatorGoesDown) {
  EXPECT_EQ(run_pair("at 300 ms update\nat 330 ms operator down for 1 s", milliseconds{20000}),
            "update: its outcome is not known: the operator went down; old old ");
}

TEST(Nodes, OneActionFollowsTheOtherAndAnUndeployedCellCannotBeUndeployed) {
  EXPECT_EQ(run_pair("at 300 ms undeploy\nat 300 ms deploy\nat 300 ms undeploy\nat 300 ms undeploy"),
            "undeploy: done; deploy: done; undeploy: done; undeploy: failed; the devices run what they ran "
            "before: no device runs the cell; none none ");
  EXPECT_EQ(run_pair("at 2900 ms update"),
            "update: its outcome is not known: the simulation ended before; none none ");
}

/// A cell in which a program of device a writes to a thread module of device b.
Cell writing(const std::string& period, const std::string& file, const std::string& more = "") {
  return Cell::of("<device name=\"a\">" + program("m", "10000000") + "</device><device name=\"b\">" +
                      thread("m", period, more) +
                      "</device><connection from=\"a.m.out\" to=\"b.m.in\" kind=\"queue\" depth=\"8\"/>",
                  file);
}

TEST(Nodes, ADeviceThatWouldHavePowerAgainAfterTheEndStaysDown) {
  for (int ms = 11; ms < 40; ++ms)
    EXPECT_EQ(run_pair("at 2990 ms a down for " + std::to_string(ms) + " ms"), "none old ") << ms;
}

TEST(Nodes, TheReportShowsTheLastStateOfADeviceThatIsDown) {
  const Outcome run =
      writing("10000000", "cell.xml").run({.length = milliseconds{2000}}, "at 1 s b down for 5 s");
  EXPECT_EQ(run.course.report["devices"][1]["modules"][0]["cycles"], 100);
}

TEST(Nodes, NothingOfADeviceRunsWithoutPower) {
  const Outcome run =
      writing("10000000", "cell.xml").run({.length = milliseconds{2000}}, "at 1 s a down for 100 ms");
  std::size_t bodies = 0;
  for (const std::string& line : run.lines) bodies += line.find(" a.m body ") == std::string::npos ? 0 : 1;
  EXPECT_LT(bodies, 170U) << "it begins again after its node has found out that it is alone";
}

TEST(Nodes, SamplesReachADeviceThatHasBeenUpdatedAlone) {
  const Version update = writing("20000000", "new.xml").version();
  const Outcome run = writing("10000000", "cell.xml")
                          .run({.length = milliseconds{3000}, .update = &update}, "at 300 ms update");
  std::size_t read = 0;
  for (const std::string& line : run.lines) read += line.find(" b.m.in read ") == std::string::npos ? 0 : 1;
  EXPECT_GT(read, 200U) << "of 300 samples";
}

TEST(Nodes, APropertyIsChangedWhileTheModuleRuns) {
  const auto property = [](const char* value) {
    return std::string{"<property><value name=\"gain\">"} + value + "</value></property>";
  };
  const Version update = writing("10000000", "new.xml", property("2")).version();
  const Outcome run = writing("10000000", "cell.xml", property("1"))
                          .run({.length = milliseconds{2000}, .update = &update}, "at 300 ms update");
  EXPECT_EQ(run.course.reports.at(0).outcome, simulation::Outcome::done);
  EXPECT_EQ(module_of(run, "m")["cycles"], 200) << "device a";
  EXPECT_EQ(run.course.report["devices"][1]["modules"][0]["cycles"], 200) << "device b was not restarted";
}

TEST(Nodes, AFaultWithoutEffectIsReported) {
  const Outcome run = pair("10000000", "cell.xml")
                          .run({.length = milliseconds{900}}, "at 300 ms undeploy\nat 600 ms a.m fail");
  EXPECT_THAT(run.course.without_effect,
              testing::ElementsAre("'at 600000 us a.m fail' has no effect: the device runs no cell then"));
}

TEST(Nodes, ASecondNodeOfADeviceDoesNotBegin) {
  EXPECT_EQ(run_pair("at 300 ms a twin"), "old old ");
  EXPECT_THAT(run_pair("at 300 ms a twin\nat 1 s undeploy"),
              StartsWith("undeploy: its outcome is not known: device a: 2 nodes have this name"));
  EXPECT_THAT(run_pair("at 300 ms a twin\nat 1 s update"),
              StartsWith("update: failed; the devices run what they ran before"));
}

TEST(Nodes, TheOthersStopWithinMillisecondsAfterAFaultThatStopsTheCell) {
  const Outcome run = guarded().run({.length = milliseconds{300}}, "at 100 ms a.m fail");
  EXPECT_EQ(run.course.failures.size(), 3U);
  EXPECT_THAT(run.course.failures[2].what, StartsWith("stops with its cell: "));
  for (const auto& device : run.course.report["devices"])
    EXPECT_LT(device["modules"][0]["cycles"], 110) << device["name"];
}

}  // namespace
}  // namespace takt::simulation::nodes_test
