#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>

namespace {

TEST(Button, HasANormallyOpenAndANormallyClosedContact) {
  takt::testing::Module module{{}};
  auto& pressed = module.out<basic::Flag>("pressed");
  auto& closed = module.out<basic::Flag>("closed");
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_FALSE(pressed.value().value());
  EXPECT_TRUE(closed.value().value());
  ASSERT_TRUE(module.set("down", "true"));
  module.step();
  EXPECT_TRUE(pressed.value().value());
  EXPECT_FALSE(closed.value().value());
  EXPECT_EQ(pressed.count(), 2U) << "the button did not write its contact every period";
}

}  // namespace
