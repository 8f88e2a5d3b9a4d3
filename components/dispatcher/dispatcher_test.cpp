#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <line.hpp>
#include <motion.hpp>

namespace {

line::PartSeen part(std::uint32_t number, const char* kind) {
  line::PartSeen seen;
  seen.number(number);
  seen.kind(kind);
  seen.offset(0.01 * number);
  return seen;
}

TEST(Dispatcher, AsksForEachPartThatHasCome) {
  takt::testing::Module module{{.sporadic = true}};
  auto& seen = module.in<line::PartSeen>("part", {.queue = 8});
  auto& request = module.out<motion::PickRequest>("request");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(), 0U);
  seen.write(part(1, "bottle"));
  seen.write(part(2, "box"));
  EXPECT_EQ(module.step(), 1U);
  ASSERT_EQ(request.values().size(), 2U);
  EXPECT_EQ(request.values()[0].number(), 1U);
  EXPECT_EQ(request.values()[1].number(), 2U);
  EXPECT_DOUBLE_EQ(request.value().offset(), 0.02);
  EXPECT_EQ(module.step(), 0U);
}

TEST(Dispatcher, LeavesBottlesWhereItIsTold) {
  takt::testing::Module module{{.sporadic = true}};
  auto& seen = module.in<line::PartSeen>("part");
  auto& request = module.out<motion::PickRequest>("request");
  ASSERT_TRUE(module.start());
  ASSERT_TRUE(module.set("bottles", "false"));  // while it runs
  seen.write(part(1, "bottle"));
  EXPECT_EQ(module.step(), 1U);
  EXPECT_EQ(request.count(), 0U);
  seen.write(part(2, "box"));
  module.step();
  EXPECT_EQ(request.value().number(), 2U);
}

}  // namespace
