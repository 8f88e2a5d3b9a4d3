#include <components/common/latest.hpp>

#include <array>
#include <thread>

#include <gtest/gtest.h>

namespace latest_test {
namespace {

TEST(Latest, HasNoValueBeforeTheFirstPublish) {
  Latest<int> latest;
  EXPECT_FALSE(latest.take());
  EXPECT_EQ(latest.taken(), 0);
}

TEST(Latest, ReturnsTheNewestValueOnlyOnce) {
  Latest<int> latest;
  for (int i = 1; i <= 5; ++i) {
    latest.writing() = i;
    latest.publish();
  }
  latest.writing() = 6;  // written, but not published
  EXPECT_TRUE(latest.take());
  EXPECT_EQ(latest.taken(), 5);
  EXPECT_FALSE(latest.take());
  EXPECT_EQ(latest.taken(), 5);
}

TEST(Latest, NeverMixesTwoValuesWhenReadDuringAWrite) {
  constexpr std::uint64_t kLast = 300'000;
  Latest<std::array<std::uint64_t, 16>> latest;
  std::thread writer{[&] {
    for (std::uint64_t i = 1; i <= kLast; ++i) {
      latest.writing().fill(i);
      latest.publish();
    }
  }};
  std::uint64_t last = 0;
  while (last != kLast) {
    if (!latest.take()) continue;
    for (const std::uint64_t x : latest.taken()) ASSERT_EQ(x, latest.taken()[0]);
    ASSERT_GT(latest.taken()[0], last);
    last = latest.taken()[0];
  }
  writer.join();
}

}  // namespace
}  // namespace latest_test
