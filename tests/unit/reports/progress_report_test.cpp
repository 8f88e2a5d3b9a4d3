#include "terminal/progress.hpp"

#include <gmock/gmock.h>

namespace takt::tool::progress_report_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

TEST(ShareText, ShowsAProgressBarAndAPercentage) {
  EXPECT_EQ(share_text(0, "none", {}), "[....................]   0 %  none");
  EXPECT_EQ(share_text(0.42, "4.2 of 10 s", {}), "[########............]  42 %  4.2 of 10 s");
  EXPECT_EQ(share_text(1, "all", {}), "[####################] 100 %  all");
  EXPECT_EQ(share_text(7, "more", {}), "[####################] 100 %  more");
  EXPECT_EQ(share_text(-1, "less", {}), "[....................]   0 %  less");
}

TEST(BringUp, ReportsEachStateOnlyOnce) {
  BringUp bring_up{2};
  std::vector<BroughtUp> devices{{.device = "robot", .state = "waiting", .modules = {}}};
  EXPECT_THAT(bring_up.news(devices), IsEmpty());
  devices[0] = {.device = "robot", .state = "preparing", .modules = {{"arm", "IDLE"}, {"servo", "START"}}};
  EXPECT_THAT(bring_up.news(devices), UnorderedElementsAre("robot: preparing", "robot.servo: START"));
  EXPECT_THAT(bring_up.news(devices), IsEmpty());
  devices[0].modules["arm"] = "RECOVER";
  EXPECT_THAT(bring_up.news(devices), ElementsAre("robot.arm: RECOVER"));
  devices[0] = {
      .device = "robot", .state = "running", .modules = {{"arm", "EXECUTING"}, {"servo", "EXECUTING"}}};
  EXPECT_THAT(bring_up.news(devices),
              UnorderedElementsAre("robot: running", "robot.arm: EXECUTING", "robot.servo: EXECUTING"));
}

TEST(BringUp, ShowsHowManyModulesAreReadyAndWhichIsNot) {
  const BringUp bring_up{3};
  EXPECT_EQ(bring_up.text({}, {}), "[....................]   0 %  0 of 3 modules ready");
  EXPECT_EQ(
      bring_up.text(
          {{.device = "robot", .state = "preparing", .modules = {{"arm", "START"}, {"servo", "IDLE"}}}}, {}),
      "[######..............]  33 %  1 of 3 modules ready, robot.servo is in IDLE");
  EXPECT_EQ(BringUp{0}.text({}, {}), "[####################] 100 %  0 of 0 modules ready");
}

}  // namespace
}  // namespace takt::tool::progress_report_test
