#include "gate.hpp"

#include <gtest/gtest.h>

#include <string>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace logic_gate {
namespace {

using common::flag;

TEST(Gate, FollowsItsTruthTableForAllInputs) {
  for (std::uint32_t used = 1; used < 16; ++used) {
    for (std::uint32_t given = 0; given < 16; ++given) {
      bool all = true;
      bool any = false;
      bool odd = false;
      for (int i = 0; i < 4; ++i) {
        if ((used >> i & 1) == 0) continue;
        const bool value = (given >> i & 1) != 0;
        all = all && value;
        any = any || value;
        odd = odd != value;
      }
      EXPECT_EQ(output(*function_of("and"), used, given), all);
      EXPECT_EQ(output(*function_of("or"), used, given), any);
      EXPECT_EQ(output(*function_of("xor"), used, given), odd);
      EXPECT_EQ(output(*function_of("nand"), used, given), !all);
      EXPECT_EQ(output(*function_of("nor"), used, given), !any);
      EXPECT_EQ(output(*function_of("not"), used, given), !any);
    }
  }
  EXPECT_FALSE(function_of("AND"));
}

TEST(LogicGate, WritesNothingUntilEveryConnectedInputHasAValue) {
  takt::testing::Module module;
  auto& first = module.in<basic::Flag>("in_1");
  auto& fourth = module.in<basic::Flag>("in_4");
  auto& out = module.out<basic::Flag>("out");
  ASSERT_TRUE(module.set("function", "nor"));
  ASSERT_TRUE(module.start());
  first.write(flag(false));
  module.step(5);
  EXPECT_FALSE(out.has_value());
  fourth.write(flag(false));
  module.step();
  EXPECT_TRUE(out.value().value());
  ASSERT_TRUE(module.set("function", "or"));
  module.step();
  EXPECT_FALSE(out.value().value());
}

TEST(LogicGate, RejectsAnUnknownFunction) {
  takt::testing::Module module;
  EXPECT_EQ(module.set("function", "AND").text(),
            "property 'function' cannot be 'AND'; it takes text, and, or, xor, nand, nor or not");
}

TEST(LogicGate, DoesNotStartWithoutAConnectedInput) {
  takt::testing::Module module;
  EXPECT_EQ(module.start().text(), "no input is connected; connect a flag to one of in_1 to in_4");
}

}  // namespace
}  // namespace logic_gate
