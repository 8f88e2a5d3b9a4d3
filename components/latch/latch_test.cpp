#include "bistable.hpp"

#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace latch {
namespace {

using common::flag;

TEST(Bistable, FollowsTheTruthTableOfTheStandard) {
  for (const bool set_wins : {false, true}) {
    for (const bool before : {false, true}) {
      for (const bool set : {false, true}) {
        for (const bool reset : {false, true}) {
          Bistable bistable;
          if (before) bistable.step(true, false, set_wins);
          const bool expected = set && reset ? set_wins : set ? true : reset ? false : before;
          EXPECT_EQ(bistable.step(set, reset, set_wins), expected);
        }
      }
    }
  }
}

TEST(Latch, LetsResetWinUnlessItsKindIsSR) {
  takt::testing::Module module;
  auto& set = module.in<basic::Flag>("set");
  auto& reset = module.in<basic::Flag>("reset");
  auto& q = module.out<basic::Flag>("q");
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_FALSE(q.value().value());
  set.write(flag(true));
  module.step();
  set.write(flag(false));
  module.step(10);
  EXPECT_TRUE(q.value().value());
  set.write(flag(true));
  reset.write(flag(true));
  module.step();
  EXPECT_FALSE(q.value().value());
  ASSERT_TRUE(module.set("kind", "SR"));
  module.step();
  EXPECT_TRUE(q.value().value());
}

TEST(Latch, IsResetAfterAnError) {
  takt::testing::Module module;
  auto& set = module.in<basic::Flag>("set");
  auto& q = module.out<basic::Flag>("q");
  ASSERT_TRUE(module.start());
  set.write(flag(true));
  module.step();
  set.write(flag(false));
  ASSERT_TRUE(module.error(takt::ErrorType::budget));
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_FALSE(q.value().value());
}

}  // namespace
}  // namespace latch
