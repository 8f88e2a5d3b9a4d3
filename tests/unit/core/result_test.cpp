#include <takt/core/result.hpp>

#include <gtest/gtest.h>

namespace takt::result_test {
namespace {

TEST(Problem, HasOneSafeLineWhateverAComponentWrites) {
  const Problem problem{"module d.m", "failed: first\nsecond \x1b[31mred", "read\tthis"};
  EXPECT_EQ(to_text(problem), R"(module d.m: error: failed: first\nsecond \x1b[31mred; read\x09this)");
  EXPECT_EQ(in_words({problem}), R"(module d.m: failed: first\nsecond \x1b[31mred; read\x09this)");
  EXPECT_EQ(to_text(Problems{problem, {"", "two", ""}}), to_text(problem) + "\nerror: two");
}

}  // namespace
}  // namespace takt::result_test
