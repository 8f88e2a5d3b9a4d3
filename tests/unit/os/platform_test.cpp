#include <takt/os/platform.hpp>

#include <gtest/gtest.h>

#include <algorithm>

#include <takt/os/clock.hpp>
#include <takt/os/environment.hpp>

namespace takt::os::platform_test {
namespace {

TEST(Platform, DescribesThisMachine) {
  const Platform platform = describe_platform();
  EXPECT_GT(platform.processors, 0);
  EXPECT_FALSE(platform.name.empty());
  EXPECT_FALSE(platform.kernel.empty());
  EXPECT_EQ(2, std::count(platform.load.begin(), platform.load.end(), ' ')) << platform.load;
}

TEST(StolenTime, NeverDecreases) {
  const Nanoseconds before = stolen_time();
  EXPECT_GE(before.count(), 0);
  EXPECT_GE(stolen_time(), before);
}

TEST(ThreadTime, IncreasesWhileComputingButNotWhileSleeping) {
  const Nanoseconds before = thread_time();
  sleep_until(now() + std::chrono::milliseconds{20});
  const Nanoseconds slept = thread_time();
  EXPECT_LT(slept - before, std::chrono::milliseconds{20});
  while (thread_time() - slept < std::chrono::milliseconds{1})
    continue;  // the loop ends only if computing increases thread_time()
}

TEST(ProcessMemory, IsZeroOnlyIfThereIsNoSuchProcess) {
  EXPECT_GT(memory_of(process_id()), 100'000U);
  EXPECT_EQ(0U, memory_of(-1));
}

}  // namespace
}  // namespace takt::os::platform_test
