#include <takt/dds/picture.hpp>

#include <gmock/gmock.h>

#include <takt/dds/words.hpp>

namespace takt::dds::picture_test {
namespace {

DeviceStatus device(const std::string& cell, const std::string& name, const std::string& node) {
  DeviceStatus status;
  set(status.path(), path_of(cell, name));
  set(status.cell(), cell);
  set(status.device(), name);
  set(status.node(), node);
  return status;
}

LifecycleStatus module(const std::string& name, LifecycleState state) {
  LifecycleStatus status;
  set(status.path(), path_of("cell", "robot", name));
  set(status.cell(), "cell");
  set(status.device(), "robot");
  set(status.name(), name);
  status.state(state);
  return status;
}

template <class Status>
Status only_key(const Status& whole) {
  Status key;
  key.path(whole.path());
  return key;
}

TEST(Picture, IsEmptyAtFirst) {
  Picture picture;
  EXPECT_TRUE(picture.devices().empty());
  EXPECT_TRUE(picture.devices("robot").empty());
  picture.lost(7);
  picture.gone(device("-", "robot", ""), 7);
  picture.gone(module("servo", STATE_IDLE));
  EXPECT_TRUE(picture.devices().empty());
}

TEST(Picture, AModuleThatIsHeardOfBeforeItsDeviceIsOnIt) {
  Picture picture;
  picture.heard(module("servo", STATE_START));
  EXPECT_TRUE(picture.devices().empty());
  picture.heard(device("cell", "robot", "a"), 1);
  ASSERT_EQ(picture.devices().size(), 1U);
  EXPECT_EQ(picture.devices()[0].deployment.modules.at("servo").state(), STATE_START);
}

TEST(Picture, AModuleExecutesOnADeviceThatIsAlive) {
  Picture picture;
  EXPECT_FALSE(picture.executes("cell", "robot", "servo"));
  picture.heard(module("servo", STATE_EXECUTING));
  EXPECT_FALSE(picture.executes("cell", "robot", "servo")) << "nobody has heard of its device";
  DeviceStatus robot = device("cell", "robot", "a");
  robot.sequence_number(1);
  picture.heard(robot, 1);
  EXPECT_TRUE(picture.executes("cell", "robot", "servo"));
  EXPECT_FALSE(picture.executes("cell", "robot", "arm"));
  EXPECT_FALSE(picture.executes("other", "robot", "servo"));
  picture.heard(module("servo", STATE_RECOVER));
  EXPECT_FALSE(picture.executes("cell", "robot", "servo"));
}

TEST(Picture, OfADeviceThatIsBackTheFirstStatusIsNotEnough) {
  Picture picture;
  DeviceStatus robot = device("cell", "robot", "a");
  robot.sequence_number(5);
  picture.heard(robot, 1);
  picture.heard(module("servo", STATE_EXECUTING));
  picture.lost(1);
  EXPECT_FALSE(picture.executes("cell", "robot", "servo"));
  robot.sequence_number(9);
  picture.heard(robot, 1);
  EXPECT_FALSE(picture.executes("cell", "robot", "servo")) << "it may have stopped meanwhile";
  robot.sequence_number(10);
  picture.heard(robot, 1);
  EXPECT_TRUE(picture.executes("cell", "robot", "servo"));
}

TEST(Picture, ALostDeviceStaysWithWhatWasLastHeard) {
  Picture picture;
  picture.heard(device("cell", "robot", "a"), 1);
  picture.heard(device("cell", "line", "b"), 2);
  picture.heard(module("servo", STATE_EXECUTING));
  picture.lost(1);
  ASSERT_EQ(picture.devices("robot").size(), 1U);
  EXPECT_FALSE(picture.devices("robot")[0].alive);
  EXPECT_EQ(picture.devices("robot")[0].deployment.modules.at("servo").state(), STATE_EXECUTING);
  EXPECT_TRUE(picture.devices("line")[0].alive);
}

TEST(Picture, ADeviceThatIsHeardAgainIsAlive) {
  Picture picture;
  picture.heard(device("cell", "robot", "a"), 1);
  picture.lost(1);
  picture.heard(device("cell", "robot", "a"), 1);
  EXPECT_TRUE(picture.devices("robot")[0].alive);
}

TEST(Picture, ANewNodeTakesThePlaceOfALostOneOfItsName) {
  Picture picture;
  picture.heard(device("cell", "robot", "a"), 1);
  picture.lost(1);
  picture.heard(device("-", "robot", "b"), 2);
  ASSERT_EQ(picture.devices("robot").size(), 1U);
  EXPECT_EQ(picture.devices("robot")[0].node(), "b");
  EXPECT_TRUE(picture.devices("robot")[0].deployment.modules.empty());
}

TEST(Picture, WhatALostNodeHadIsNotTakenForWhatItsSuccessorHas) {
  Picture picture;
  picture.heard(device("cell", "robot", "a"), 1);
  picture.heard(module("servo", STATE_EXECUTING));
  picture.lost(1);
  picture.heard(device("-", "robot", "b"), 2);
  picture.heard(device("cell", "robot", "b"), 2);
  EXPECT_TRUE(picture.devices("robot")[0].deployment.modules.empty());
}

TEST(Picture, ANodeThatTakesUpItsCellAgainKeepsWhatWasHeardBeforeIt) {
  Picture picture;
  picture.heard(device("cell", "robot", "a"), 1);
  picture.lost(1);
  picture.heard(module("servo", STATE_IDLE));
  picture.heard(device("cell", "robot", "b"), 2);
  EXPECT_EQ(picture.devices("robot")[0].deployment.modules.at("servo").state(), STATE_IDLE);
}

TEST(Picture, TwoLivingNodesOfOneNameAreTwo) {
  Picture picture;
  picture.heard(device("-", "robot", "a"), 1);
  picture.heard(device("-", "robot", "b"), 2);
  EXPECT_EQ(picture.devices("robot").size(), 2U);
}

TEST(Picture, ADeviceThatIsDeployedToChangesItsKeyAndStays) {
  Picture picture;
  picture.heard(device("-", "robot", "a"), 1);
  picture.heard(device("cell", "robot", "a"), 1);
  picture.gone(only_key(device("-", "robot", "a")), 1);
  ASSERT_EQ(picture.devices().size(), 1U);
  EXPECT_EQ(picture.devices()[0].status.cell(), "cell");
}

TEST(Picture, ADeviceThatTakesBackItsOnlyKeyHasLeft) {
  Picture picture;
  picture.heard(device("-", "robot", "a"), 1);
  picture.heard(device("-", "robot", "b"), 2);
  picture.gone(only_key(device("-", "robot", "a")), 1);
  ASSERT_EQ(picture.devices().size(), 1U);
  EXPECT_EQ(picture.devices()[0].node(), "b");
}

TEST(Picture, AModuleThatIsUndeployedIsForgottenWithItsNumbers) {
  Picture picture;
  picture.heard(device("cell", "robot", "a"), 1);
  picture.heard(module("servo", STATE_DESTRUCT));
  picture.heard(module("arm", STATE_DESTRUCT));
  PortStatus port;
  set(port.cell(), "cell");
  set(port.device(), "robot");
  set(port.name(), "servo");
  set(port.port(), "effort");
  picture.heard(port);
  ASSERT_EQ(picture.devices()[0].deployment.ports.count("servo.effort"), 1U);
  picture.gone(only_key(module("servo", STATE_DESTRUCT)));
  const SeenDeployment left = picture.devices()[0].deployment;
  EXPECT_EQ(left.modules.count("servo"), 0U);
  EXPECT_EQ(left.modules.count("arm"), 1U);
  EXPECT_TRUE(left.ports.empty());
}

TEST(Picture, DevicesAreInTheOrderOfTheirNames) {
  Picture picture;
  picture.heard(device("-", "station", "a"), 1);
  picture.heard(device("-", "line", "z"), 2);
  picture.heard(device("-", "robot", "m"), 3);
  std::vector<std::string> names;
  for (const SeenDevice& device : picture.devices()) names.push_back(device.name());
  EXPECT_THAT(names, testing::ElementsAre("line", "robot", "station"));
}

}  // namespace
}  // namespace takt::dds::picture_test
