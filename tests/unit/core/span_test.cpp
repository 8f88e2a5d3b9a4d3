#include <takt/core/span.hpp>

#include <gtest/gtest.h>

namespace takt::span_test {
namespace {

using namespace std::chrono_literals;

TEST(TimeSpan, IsClampedInsteadOfOverflowing) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  EXPECT_EQ(span(3, 10), 7ns);
  EXPECT_EQ(span(10, 3), -7ns);
  EXPECT_EQ(span(kMin, kMax), Nanoseconds{kMax});
  EXPECT_EQ(span(kMax, kMin), Nanoseconds{-kMax});
  EXPECT_EQ(span(0, kMin), Nanoseconds{-kMax});
  EXPECT_EQ(span(kMin, 0), Nanoseconds{kMax});
}

}  // namespace
}  // namespace takt::span_test
