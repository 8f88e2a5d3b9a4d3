#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <string>
#include <utility>

#include <takt/os/environment.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/real_time.hpp>

namespace takt::os::thread_test {
namespace {

TEST(Thread, ShortensItsNameToTheLinuxLimit) {
  std::array<char, 16> name{};
  auto thread = Thread::start(
      {.name = "a name of more than fifteen"},
      [&name] { ::pthread_getname_np(::pthread_self(), name.data(), name.size()); }, nullptr);
  ASSERT_TRUE(thread.ok());
  thread->join();
  EXPECT_EQ(std::string{name.data()}, "a name of more ");
  EXPECT_FALSE(thread->running());
}

TEST(Thread, HasTheRequestedStackSize) {
  std::size_t size = 0;
  auto thread = Thread::start(
      {.name = "t", .stack_bytes = 2 * 1024 * 1024},
      [&size] {
        pthread_attr_t attributes;
        ::pthread_getattr_np(::pthread_self(), &attributes);
        ::pthread_attr_getstacksize(&attributes, &size);
        ::pthread_attr_destroy(&attributes);
      },
      nullptr);
  thread->join();
  EXPECT_GE(size, 2U * 1024 * 1024) << "the C library may reuse a larger stack of an ended thread";
}

TEST(Thread, LeavesSignalsToOtherThreadsIfItShallHandleNone) {
  for (const bool handles : {true, false}) {
    sigset_t blocked;
    auto thread = Thread::start(
        {.name = "t", .handles_signals = handles},
        [&blocked] { ::pthread_sigmask(SIG_BLOCK, nullptr, &blocked); }, nullptr);
    ASSERT_TRUE(thread.ok());
    thread->join();
    for (const int to_process : {SIGTERM, SIGINT, SIGUSR1, SIGCHLD, SIGRTMIN})
      EXPECT_EQ(::sigismember(&blocked, to_process), handles ? 0 : 1) << to_process;
    for (const int own : {SIGSEGV, SIGBUS, SIGFPE, SIGSYS}) EXPECT_EQ(::sigismember(&blocked, own), 0) << own;
  }
}

// A thread-local variable, which glibc places on the stack of each thread. The variable leaves less than half
// of a small stack free.
thread_local std::array<char, 300 * 1024> large{};

TEST(Thread, RunsEvenIfThreadLocalVariablesFillMostOfItsStack) {
  std::atomic<bool> ran{false};
  auto thread = Thread::start(
      {.name = "t", .stack_bytes = 448 * 1024},
      [&ran] {
        asm volatile("" : : "r"(large.data()) : "memory");
        ran = true;
      },
      nullptr);
  if (!thread) GTEST_SKIP() << to_text(thread.problems());
  thread->join();
  EXPECT_TRUE(ran);
}

TEST(Thread, RunsOnTheGivenCpu) {
  const int cpu = read_cpus().ordinary.back();
  Problems refused;
  cpu_set_t set;
  CPU_ZERO(&set);
  auto thread = Thread::start(
      {.name = "t", .cpus = {cpu}}, [&set] { ::sched_getaffinity(0, sizeof set, &set); }, &refused);
  thread->join();
  EXPECT_TRUE(refused.empty());
  EXPECT_EQ(CPU_COUNT(&set), 1);
  EXPECT_TRUE(CPU_ISSET(static_cast<unsigned>(cpu), &set));
}

TEST(Thread, RunsEvenIfItsCpuIsMissing) {
  Problems refused;
  std::atomic<bool> ran{false};
  auto thread = Thread::start(
      {.name = "t", .cpus = {1000}}, [&ran] { ran = true; }, &refused);
  ASSERT_TRUE(thread.ok());
  ASSERT_EQ(refused.size(), 1U) << "the problem is reported before start() returns";
  EXPECT_EQ(refused[0].where, "thread t");
  EXPECT_NE(refused[0].what.find("CPU 1000 is denied"), std::string::npos);
  thread->join();
  EXPECT_TRUE(ran);
}

TEST(MakeRealTime, DoesNotNameACapabilityThatTheProcessHas) {
  if (!is_root() || !may_have_priority()) GTEST_SKIP() << "needs root with CAP_SYS_NICE";
  const auto denied = make_real_time(0, 1000);
  ASSERT_FALSE(denied.ok());
  EXPECT_EQ(denied.problems()[0].fix.find("CAP_SYS_NICE"), std::string::npos) << denied.problems()[0].fix;
}

TEST(Thread, RunsEvenIfItsPriorityIsDenied) {
  Problems refused;
  int policy = -1;
  auto thread = Thread::start(
      {.name = "t", .priority = 1000}, [&policy] { policy = ::sched_getscheduler(0); }, &refused);
  ASSERT_TRUE(thread.ok());
  thread->join();
  ASSERT_EQ(refused.size(), 1U);
  EXPECT_NE(refused[0].what.find("SCHED_FIFO 1000 is denied"), std::string::npos);
  EXPECT_FALSE(refused[0].fix.empty());
  EXPECT_EQ(policy, SCHED_OTHER);
}

TEST(Thread, HasItsPriorityIfTheSystemAllowsIt) {
  if (const auto may = may_be_real_time(); !may) GTEST_SKIP() << to_text(may.problems());
  Problems refused;
  int policy = -1;
  sched_param parameter{};
  auto thread = Thread::start(
      {.name = "t", .priority = 7},
      [&] {
        policy = ::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
        ::sched_getparam(0, &parameter);
      },
      &refused);
  thread->join();
  EXPECT_TRUE(refused.empty());
  EXPECT_EQ(policy, SCHED_FIFO);
  EXPECT_EQ(parameter.sched_priority, 7);
}

TEST(Thread, IsJoinedWhenItsLastOwnerIsDestroyed) {
  std::atomic<int> ran{0};
  {
    auto first = Thread::start(
        {.name = "t"}, [&ran] { ++ran; }, nullptr);
    Thread second{std::move(*first)};
    EXPECT_TRUE(second.running());
    EXPECT_FALSE(first->running());
    auto third = Thread::start(
        {.name = "t"}, [&ran] { ++ran; }, nullptr);
    second = std::move(*third);  // this assignment joins the thread that `second` owned before
    EXPECT_GE(ran, 1);
  }
  EXPECT_EQ(ran, 2);
}

}  // namespace
}  // namespace takt::os::thread_test
