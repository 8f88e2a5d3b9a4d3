#include "edge_detector.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace edge {
namespace {

using common::flag;

std::string edges_of(bool rising, bool falling, const std::string& in) {
  EdgeDetector detector;
  detector.rising = rising;
  detector.falling = falling;
  std::string out;
  for (const char c : in) out += detector.step(c == '1') ? '1' : '0';
  return out;
}

TEST(EdgeDetector, ReportsEachEdgeInOneStepOnly) {
  const std::string in = "0110010111000";
  EXPECT_EQ(edges_of(true, false, in), "0100010100000");
  EXPECT_EQ(edges_of(false, true, in), "0001001000100");
  EXPECT_EQ(edges_of(true, true, in), "0101011100100");
}

TEST(EdgeDetector, DoesNotCountTheFirstValueAsAnEdge) {
  EXPECT_EQ(edges_of(true, true, "111"), "000");
  EXPECT_EQ(edges_of(true, true, "000"), "000");
}

class Edge : public ::testing::Test {
 protected:
  takt::testing::Module module;
  takt::testing::In<basic::Flag>& in = module.in<basic::Flag>("in", {.queue = 16});
  takt::testing::Out<basic::Flag>& q = module.out<basic::Flag>("q");
  takt::testing::Out<basic::Count>& count = module.out<basic::Count>("count");
  bool is(bool value) {
    in.write(flag(value));
    module.step();
    return q.value().value();
  }
};

TEST_F(Edge, SetsItsOutputForOneCycleAfterAnEdge) {
  ASSERT_TRUE(module.start());
  EXPECT_FALSE(is(false));
  EXPECT_TRUE(is(true));
  EXPECT_FALSE(is(true));
  module.step(10);
  EXPECT_FALSE(q.value().value());
  EXPECT_FALSE(is(false));
  EXPECT_TRUE(is(true));
}

TEST_F(Edge, TreatsATrueFirstSampleAsAnEdgeIfConfigured) {
  ASSERT_TRUE(module.set("at_start", "true"));
  ASSERT_TRUE(module.start());
  EXPECT_TRUE(is(true));
  EXPECT_FALSE(is(true));
}

TEST_F(Edge, TreatsAFalseFirstSampleAsAFallingEdgeIfConfigured) {
  ASSERT_TRUE(module.set("at_start", "true"));
  ASSERT_TRUE(module.set("direction", "falling"));
  ASSERT_TRUE(module.start());
  EXPECT_TRUE(is(false));
}

TEST_F(Edge, CountsEveryEdgeInItsQueue) {
  ASSERT_TRUE(module.set("direction", "both"));
  ASSERT_TRUE(module.start());
  std::mt19937 random(16);
  bool last = false;
  std::int64_t expected = 0;
  is(false);
  for (int i = 0; i < 3000; ++i) {
    std::int64_t edges = 0;
    for (auto n = random() % 6; n > 0; --n) {
      const bool value = random() % 2 == 0;
      edges += value != last ? 1 : 0;
      last = value;
      in.write(flag(value));
    }
    expected += edges;
    module.step();
    ASSERT_EQ(count.value().value(), expected) << i;
    ASSERT_EQ(q.value().value(), edges > 0) << i;
  }
}

TEST_F(Edge, ReportsNoEdgeIfTheFlagChangedDuringAnError) {
  ASSERT_TRUE(module.start());
  is(false);
  ASSERT_TRUE(module.error(takt::ErrorType::budget));
  in.write(flag(true));
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_FALSE(q.value().value());
}

}  // namespace
}  // namespace edge
