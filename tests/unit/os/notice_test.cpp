#include <takt/os/notice.hpp>

#include <gtest/gtest.h>

#include <thread>

#include <takt/os/signals.hpp>

namespace takt::os::notice_test {
namespace {

TEST(Notice, IsReceivedOnceEvenIfGivenTwice) {
  auto notice = Notice::create();
  ASSERT_TRUE(notice.ok());
  EXPECT_FALSE(wait_readable({&notice->fd()}, 0));
  EXPECT_FALSE(notice->take());
  notice->give();
  notice->give();
  EXPECT_TRUE(wait_readable({&notice->fd()}, 0));
  EXPECT_TRUE(notice->take());
  EXPECT_FALSE(notice->take());
  EXPECT_FALSE(wait_readable({&notice->fd()}, 0));
}

TEST(Notice, WakesAWaitingThread) {
  auto notice = Notice::create();
  ASSERT_TRUE(notice.ok());
  std::thread other{[&] { notice->give(); }};
  EXPECT_TRUE(wait_readable({&notice->fd()}, 60'000));
  other.join();
}

}  // namespace
}  // namespace takt::os::notice_test
