#include <takt/os/system_calls.hpp>

#include <gtest/gtest.h>
#include <sys/syscall.h>

namespace takt::os::system_calls_test {
namespace {

TEST(SystemCalls, HaveNames) {
  EXPECT_EQ(system_call_name(SYS_write), "write");
  EXPECT_EQ(system_call_name(SYS_clock_nanosleep), "clock_nanosleep");
  EXPECT_EQ(system_call_name(SYS_futex), "futex");
}

TEST(SystemCalls, AreShownAsNumbersIfUnknown) {
  EXPECT_EQ(system_call_name(-1), "system call -1");
  EXPECT_EQ(system_call_name(123456), "system call 123456");
}

}  // namespace
}  // namespace takt::os::system_calls_test
