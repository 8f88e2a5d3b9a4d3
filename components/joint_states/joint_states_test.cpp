#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <motion.hpp>
#include <sensor_msgs.hpp>

#include "names.hpp"

namespace {

using sensor_msgs::msg::JointState;

TEST(JointStates, PublishesEachMeasurementOnce) {
  takt::testing::Module module{{.period = std::chrono::milliseconds{20}}};
  auto& measured = module.in<motion::JointState>("measured");
  auto& published = module.out<JointState>("joint_states");
  ASSERT_TRUE(module.start());
  module.step(10);
  EXPECT_EQ(published.count(), 0U);
  motion::JointState arm;
  arm.position()[5] = 1.5;
  arm.velocity()[0] = -2;
  measured.write(arm);
  module.step();
  ASSERT_EQ(published.count(), 1U);
  const JointState state = published.value();
  EXPECT_EQ(state.position(), (std::vector<double>{0, 0, 0, 0, 0, 1.5}));
  EXPECT_EQ(state.velocity(), (std::vector<double>{-2, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(state.effort().empty());
  EXPECT_STREQ(state.name().at(5).c_str(), "joint6");
  EXPECT_STREQ(state.header().frame_id().c_str(), "base_link");
  EXPECT_GT(state.header().stamp().sec(), 1'700'000'000);
  EXPECT_LT(state.header().stamp().nanosec(), 1'000'000'000U);
  module.step(10);
  EXPECT_EQ(published.count(), 1U) << "a message was published without a new measurement";
}

TEST(JointStates, RejectsNamesForOnlyThreeAxes) {
  takt::testing::Module module{{}};
  ASSERT_TRUE(module.set("names", "a b c"));
  EXPECT_NE(module.initialize().text().find("'names' has 3 names"), std::string::npos);
}
TEST(JointStates, RejectsANameLongerThan63Characters) {
  takt::testing::Module module{{}};
  ASSERT_TRUE(module.set("names", "a b c d e " + std::string(64, 'x')));
  EXPECT_NE(module.initialize().text().find("is too long"), std::string::npos);
}
TEST(AxisNames, AreSeparatedByWhiteSpace) {
  EXPECT_EQ(joint_states::words("  a  bc\td "), (std::vector<std::string>{"a", "bc", "d"}));
  EXPECT_TRUE(joint_states::words(" ").empty());
}

}  // namespace
