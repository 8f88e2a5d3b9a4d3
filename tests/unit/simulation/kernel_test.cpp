#include "kernel.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace takt::simulation::kernel_test {
namespace {

using testing::ElementsAre;

constexpr Instant kBegin = from_ns(1000);
constexpr Nanoseconds kTen{10};

/// Records texts, each with the virtual time in ns since kBegin.
class Log {
 public:
  explicit Log(Kernel& kernel) : kernel_(kernel) {}
  void operator()(const std::string& what) {
    lines.push_back(what + " " + std::to_string((kernel_.now() - kBegin).count()));
  }
  std::vector<std::string> lines;

 private:
  Kernel& kernel_;
};

TEST(SimulatedKernel, ReturnsAtTheEndIfNothingHappens) {
  Kernel kernel{kBegin};
  kernel.run_until(kBegin + kTen);
  EXPECT_EQ(kBegin + kTen, kernel.now());
}

TEST(SimulatedKernel, RunsThreadsOnDifferentCpusInParallel) {
  Kernel kernel{kBegin};
  Log log{kernel};
  kernel.spawn({}, [&] {
    kernel.work(kTen);
    log("a");
  });
  kernel.spawn({}, [&] {
    kernel.work(kTen);
    log("b");
  });
  kernel.run_until(kBegin + 3 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("a 10", "b 10"));
}

TEST(SimulatedKernel, CountsTheCpuTimeOfAThreadThatIsReady) {
  Kernel kernel{kBegin};
  Cpu cpu;
  const Strand& low = kernel.spawn({.cpu = &cpu, .priority = 1}, [&] {
    kernel.work(kTen);
    kernel.sleep_until(kBegin + 3 * kTen);
    kernel.work(kTen);
  });
  kernel.spawn({.cpu = &cpu, .priority = 2}, [&] {
    kernel.sleep_until(kBegin + Nanoseconds{4});
    kernel.work(kTen);
  });
  const auto ran_at = [&](std::int64_t time) {
    kernel.run_until(kBegin + Nanoseconds{time});
    return kernel.ran_if_ready(low.id());
  };
  EXPECT_EQ(ran_at(3), Nanoseconds{3});
  EXPECT_EQ(ran_at(13), Nanoseconds{4}) << "the other thread has the CPU";
  EXPECT_EQ(ran_at(18), Nanoseconds{8});
  EXPECT_EQ(ran_at(25), std::nullopt) << "the thread sleeps";
  EXPECT_EQ(ran_at(31), Nanoseconds{11});
  EXPECT_EQ(ran_at(50), std::nullopt) << "the thread has ended";
  EXPECT_EQ(kernel.ran_if_ready(0), std::nullopt) << "no thread has this id";
}

TEST(SimulatedKernel, PreemptsAThreadOfLowerPriorityOnTheSameCpu) {
  Kernel kernel{kBegin};
  Log log{kernel};
  Cpu cpu;
  kernel.spawn({.cpu = &cpu, .priority = 1}, [&] {
    log("low");
    kernel.work(kTen);
    log("low");
  });
  kernel.spawn({.cpu = &cpu, .priority = 2}, [&] {
    kernel.sleep_until(kBegin + Nanoseconds{4});
    log("high");
    kernel.work(Nanoseconds{3});
    log("high");
  });
  kernel.run_until(kBegin + 3 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("low 0", "high 4", "high 7", "low 13"));
}

TEST(SimulatedKernel, DoesNotPreemptAThreadOfEqualPriority) {
  Kernel kernel{kBegin};
  Log log{kernel};
  Cpu cpu;
  kernel.spawn({.cpu = &cpu, .priority = 1}, [&] {
    kernel.work(kTen);
    log("first");
    kernel.work(kTen);
    log("first");
  });
  kernel.spawn({.cpu = &cpu, .priority = 1}, [&] {
    log("second");
    kernel.work(kTen);
    log("second");
  });
  kernel.run_until(kBegin + 10 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("first 10", "first 20", "second 20", "second 30"));
}

TEST(SimulatedKernel, MakesAWokenThreadWaitForAThreadOfHigherPriority) {
  Kernel kernel{kBegin};
  Log log{kernel};
  Cpu cpu;
  kernel.spawn({.cpu = &cpu, .priority = 2}, [&] { kernel.work(kTen); });
  kernel.spawn({.cpu = &cpu, .priority = 1}, [&] { log("low"); });
  kernel.run_until(kBegin + 3 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("low 10"));
}

TEST(SimulatedKernel, EndsAWaitAfterAWakeUpOrATimeout) {
  Kernel kernel{kBegin};
  Log log{kernel};
  Strand& sleeper = kernel.spawn({}, [&] {
    log(kernel.wait(kBegin + kTen) ? "woken" : "not woken");
    log(kernel.wait(kBegin + 2 * kTen) ? "woken" : "not woken");
    kernel.sleep_until(kBegin + 3 * kTen);
    log("slept");
  });
  kernel.at(kBegin + Nanoseconds{5}, [&] {
    kernel.wake(sleeper, Nanoseconds{1});
    kernel.wake(sleeper, Nanoseconds{2});  // has no effect: the sleeper is already being woken
  });
  kernel.run_until(kBegin + 10 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("woken 6", "not woken 20", "slept 30"));
}

TEST(SimulatedKernel, MakesScheduledCallsBeforeItWakesThreadsAtTheSameInstant) {
  Kernel kernel{kBegin};
  Log log{kernel};
  kernel.at(kBegin + kTen, [&] { log("call"); });
  kernel.spawn({}, [&] {
    kernel.sleep_until(kBegin + kTen);
    log("strand");
  });
  kernel.run_until(kBegin + kTen);
  EXPECT_THAT(log.lines, ElementsAre("call 10", "strand 10"));
}

TEST(SimulatedKernel, FreesTheCpuOfAKilledThread) {
  Kernel kernel{kBegin};
  Log log{kernel};
  Cpu cpu;
  Strand& dies = kernel.spawn({.cpu = &cpu, .priority = 2}, [&] {
    kernel.work(10 * kTen);
    log("never");
  });
  kernel.spawn({.cpu = &cpu, .priority = 1}, [&] { log("free"); });
  kernel.spawn({}, [&] {
    kernel.sleep_until(kBegin + kTen);
    kernel.kill(dies);
    log("killed");
    kernel.end();
  });
  kernel.run_until(kBegin + 20 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("killed 10", "free 10"));
  EXPECT_TRUE(dies.ended());
}

TEST(SimulatedKernel, CanContinueToALaterEndTime) {
  Kernel kernel{kBegin};
  Log log{kernel};
  kernel.spawn({}, [&] {
    kernel.work(2 * kTen);
    log("done");
  });
  kernel.run_until(kBegin + kTen);
  EXPECT_THAT(log.lines, ElementsAre());
  kernel.run_until(kBegin + 2 * kTen);
  EXPECT_THAT(log.lines, ElementsAre("done 20"));
}

}  // namespace
}  // namespace takt::simulation::kernel_test
