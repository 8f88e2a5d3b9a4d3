#include <takt/client/deploy.hpp>

#include <gmock/gmock.h>

#include <takt/wire/words.hpp>

namespace takt::client::cell_devices_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;

wire::ObservedDevice device(const std::string& name, const std::string& cell, const std::string& deployment) {
  wire::ObservedDevice seen;
  wire::set(seen.status.device(), name);
  wire::set(seen.status.node(), "node of " + name);
  wire::set(seen.status.cell(), cell);
  wire::set(seen.status.deployment(), deployment);
  return seen;
}

TEST(DevicesOfACell, AreFoundByTheNameOfTheCellOrTheIdOfTheDeployment) {
  const std::vector<wire::ObservedDevice> seen{device("line", "cell", "a1"), device("press", "cell", "b2"),
                                               device("robot", "cell", "a1"), device("saw", "other", "c3"),
                                               device("free", "-", "")};
  EXPECT_THAT(deployments_of(seen, "cell"),
              ElementsAre(Pair("a1", ElementsAre("line", "robot")), Pair("b2", ElementsAre("press"))));
  EXPECT_THAT(deployments_of(seen, "b2"), ElementsAre(Pair("b2", ElementsAre("press"))));
  EXPECT_THAT(deployments_of(seen, "-"), IsEmpty());
}

TEST(DevicesOfACell, AreNotFoundIfTheOnlyKnownDeviceIsLost) {
  std::vector<wire::ObservedDevice> seen{device("line", "cell", "a1")};
  seen[0].alive = false;
  EXPECT_THAT(deployments_of(seen, "cell"), IsEmpty());
}

TEST(DevicesOfACell, IncludeTheWaitingAndTheLostDevices) {
  std::vector<wire::ObservedDevice> seen{device("line", "cell", "a1"), device("robot", "cell", "a1"),
                                         device("saw", "-", ""), device("press", "other", "c3")};
  seen[1].alive = false;
  const CellDevices sorted = sort_devices(seen, "a1", {"line", "never_seen", "press", "robot", "saw"});
  EXPECT_EQ(sorted.deployment, "a1");
  EXPECT_THAT(sorted.names, ElementsAre("line"));
  EXPECT_THAT(sorted.waiting, ElementsAre("saw"));
  EXPECT_THAT(sorted.lost, ElementsAre("never_seen", "robot")) << "press has left the cell";
}

TEST(DevicesOfACell, MayAllBeLost) {
  const CellDevices sorted = sort_devices({}, "a1", {"line", "robot"});
  EXPECT_THAT(sorted.names, IsEmpty());
  EXPECT_THAT(sorted.lost, ElementsAre("line", "robot"));
}

}  // namespace
}  // namespace takt::client::cell_devices_test
