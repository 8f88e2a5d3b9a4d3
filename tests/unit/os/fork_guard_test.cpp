#include <takt/os/fork_guard.hpp>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace takt::os::fork_guard_test {
namespace {

TEST(ForkGuard, EndsAForkedCopyOfTheProcessButNotTheProcessItself) {
  ASSERT_TRUE(guard_against_forks().ok());
  end_forked_copy();
  const int copy = ::fork();
  if (copy == 0) {
    end_forked_copy();
    ::_exit(7);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(copy, &status, 0), copy);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1);
}

}  // namespace
}  // namespace takt::os::fork_guard_test
