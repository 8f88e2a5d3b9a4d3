// Tests that the traps detect the calls that a module must not make on a real-time thread.
#include "real_time_path.hpp"

#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <mutex>

namespace takt::host::real_time_traps_test {
namespace {

/// Returns a body that calls `action` once: in cycle 100, or in a later cycle if the row of cycle 100 was
/// missed.
std::function<void(const Cycle&)> once(std::function<void()> action) {
  return [action = std::move(action), done = false](const Cycle& cycle) mutable {
    if (done || cycle.number < 100) return;
    done = true;
    action();
  };
}

class RealTimeTrap : public RealTimePath {};

TEST_F(RealTimeTrap, DetectsASystemCallOfAModule) {
  bodies[1].on_run = once([] { static_cast<void>(::syscall(SYS_getpid)); });
  run(200);
  const auto others = std::count_if(row_calls.begin(), row_calls.end(),
                                    [](const SystemCall& call) { return call.number != SYS_futex; });
  EXPECT_EQ(others, 1);
  EXPECT_EQ(std::count_if(row_calls.begin(), row_calls.end(),
                          [](const SystemCall& call) { return call.number == SYS_getpid; }),
            1);
}

TEST_F(RealTimeTrap, DetectsASystemCallOfASporadicModule) {
  bodies[kSporadic].on_run = [this, next = bodies[kSporadic].on_run](const Cycle& cycle) {
    next(cycle);
    if (blocks[kSporadic].cycles.load() == 20) static_cast<void>(::syscall(SYS_getpid));
  };
  run(200);
  EXPECT_EQ(std::count_if(sporadic_calls.begin(), sporadic_calls.end(),
                          [](const SystemCall& call) { return call.number == SYS_getpid; }),
            1);
}

TEST_F(RealTimeTrap, DetectsAnAllocationOfAModule) {
  bodies[1].on_run = once([] {
    const std::string text(100, 'x');
    asm volatile("" : : "r"(text.data()) : "memory");
  });
  run(200);
  EXPECT_EQ(seen["allocations"], 1U);
  EXPECT_EQ(seen["frees"], 1U);
}

TEST_F(RealTimeTrap, DetectsALockThatAModuleTakes) {
  std::mutex mutex;
  bodies[1].on_run = once([&mutex] { const std::lock_guard lock{mutex}; });
  run(200);
  EXPECT_EQ(seen["locks"], 2U);
}

TEST_F(RealTimeTrap, DetectsThatAModuleWaitsForAConditionVariable) {
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
  if (TAKT_SANITIZED != 0) GTEST_SKIP() << "the sanitizer makes its own system calls";
  SystemCallTrap trap;
  std::vector<SystemCall> calls;
  int failed = 0;
  os::MonotonicClock clock;
  std::thread reader{[&] {
    failed = trap.arm();
    Instant last{};
    for (int i = 0; i < 10'000; ++i) {
      const Instant now = clock.now();
      if (now < last) failed = -1;
      last = now;
    }
    calls = trap.calls();
  }};
  reader.join();
  ASSERT_EQ(failed, 0) << std::strerror(failed);
  EXPECT_TRUE(calls.empty()) << "system call " << calls.front().number
                             << ": the clock source is not the TSC, see "
                             << "/sys/devices/system/clocksource/clocksource0/current_clocksource";
}

}  // namespace
}  // namespace takt::host::real_time_traps_test
