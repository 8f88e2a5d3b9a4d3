#include <takt/core/time.hpp>

#include <gtest/gtest.h>

namespace takt::time_test {
namespace {

using namespace std::chrono_literals;

TEST(Time, IsPrintedInTheLargestExactUnit) {
  EXPECT_EQ(to_text(0ns), "0 ns");
  EXPECT_EQ(to_text(7ns), "7 ns");
  EXPECT_EQ(to_text(100us), "100 us");
  EXPECT_EQ(to_text(1500us), "1.5 ms");
  EXPECT_EQ(to_text(1000000us), "1 s");
  EXPECT_EQ(to_text(1234567ns), "1234.567 us");
  EXPECT_EQ(to_text(-1500us), "-1.5 ms");
  EXPECT_EQ(to_text(1000000001ns), "1000000.001 us");
}

}  // namespace
}  // namespace takt::time_test
