// The traps work: what a module must not do is seen.
#include "real_time_path.hpp"

#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

namespace takt::host::real_time_traps_test {
namespace {

/// What is done once, in the hundredth cycle or, where that row is lost, in the next one.
std::function<void(const Cycle&)> once(std::function<void()> what) {
  return [what = std::move(what), done = false](const Cycle& cycle) mutable {
    if (done || cycle.number < 100) return;
    done = true;
    what();
  };
}

TEST_F(RealTimePath, AModuleThatMakesASystemCallIsSeen) {
  bodies[1].on_run = once([] { static_cast<void>(::syscall(SYS_getpid)); });
  run(200);
  const auto others = std::count_if(row_calls.begin(), row_calls.end(),
                                    [](const SystemCall& call) { return call.number != SYS_futex; });
  EXPECT_EQ(others, 1);
  EXPECT_EQ(std::count_if(row_calls.begin(), row_calls.end(),
                          [](const SystemCall& call) { return call.number == SYS_getpid; }),
            1);
}

TEST_F(RealTimePath, ASporadicModuleThatMakesASystemCallIsSeen) {
  bodies[kSporadic].on_run = [this, next = bodies[kSporadic].on_run](const Cycle& cycle) {
    next(cycle);
    if (blocks[kSporadic].cycles.load() == 20) static_cast<void>(::syscall(SYS_getpid));
  };
  run(200);
  EXPECT_EQ(std::count_if(sporadic_calls.begin(), sporadic_calls.end(),
                          [](const SystemCall& call) { return call.number == SYS_getpid; }),
            1);
}

TEST_F(RealTimePath, AModuleThatAllocatesIsSeen) {
  bodies[1].on_run = once([] {
    const std::string text(100, 'x');
    asm volatile("" : : "r"(text.data()) : "memory");
  });
  run(200);
  EXPECT_EQ(seen["allocations"], 1U);
  EXPECT_EQ(seen["frees"], 1U);
}

TEST_F(RealTimePath, AModuleThatLocksIsSeen) {
  std::mutex mutex;
  bodies[1].on_run = once([&mutex] { const std::lock_guard lock{mutex}; });
  run(200);
  EXPECT_EQ(seen["locks"], 2U);
}

TEST_F(RealTimePath, AModuleThatWaitsForAConditionIsSeen) {
  std::mutex mutex;
  std::condition_variable condition;
  bodies[1].on_run = once([&] {
    std::unique_lock lock{mutex};
    condition.wait_for(lock, microseconds{1});
  });
  run(200);
  EXPECT_EQ(seen["waits"], 1U);
}

TEST(Clock, MakesNoSystemCall) {
  if (TAKT_SANITIZED != 0) GTEST_SKIP() << "the sanitizer makes system calls of its own";
  SystemCallTrap trap;
  std::vector<SystemCall> calls;
  int refused = 0;
  os::MonotonicClock clock;
  std::thread reader{[&] {
    refused = trap.arm();
    Instant last{};
    for (int i = 0; i < 10'000; ++i) {
      const Instant now = clock.now();
      if (now < last) refused = -1;
      last = now;
    }
    calls = trap.calls();
  }};
  reader.join();
  ASSERT_EQ(refused, 0) << std::strerror(refused);
  EXPECT_TRUE(calls.empty()) << "system call " << calls.front().number << ": the clock source is no TSC, see "
                             << "/sys/devices/system/clocksource/clocksource0/current_clocksource";
}

}  // namespace
}  // namespace takt::host::real_time_traps_test
