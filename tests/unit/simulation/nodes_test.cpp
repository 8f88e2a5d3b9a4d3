// What the agents of a simulated cell do when its devices lose each other.
#include <gmock/gmock.h>

#include <string>

#include "simulated.hpp"

namespace takt::simulation::nodes_test {
namespace {

using simulated::Cell;
using simulated::Outcome;
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

TEST(Nodes, TheOthersStopWithinMillisecondsAfterAFaultThatStopsTheCell) {
  const Outcome run = guarded().run({.length = milliseconds{300}}, "at 100 ms a.m fail");
  EXPECT_EQ(run.course.failures.size(), 3U);
  EXPECT_THAT(run.course.failures[2].what, StartsWith("stops with its cell: "));
  for (const auto& device : run.course.report["devices"])
    EXPECT_LT(device["modules"][0]["cycles"], 110) << device["name"];
}

}  // namespace
}  // namespace takt::simulation::nodes_test
