#include "workarounds/receive_lock.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace receive_lock_test {
namespace {

using takt::dds::ReceiveLock;

TEST(ReceiveLock, LetsNoThreadHandlePacketsDuringAPause) {
  ReceiveLock receive_lock;
  std::atomic<int> inside{0};
  std::atomic<std::uint64_t> handled{0};
  std::atomic<bool> end{false};
  std::vector<std::thread> receivers;
  for (int i = 0; i < 2; ++i) {
    receivers.emplace_back([&] {
      while (!end) {
        receive_lock.handle([&] {
          ++inside;
          ++handled;
          --inside;
        });
        std::this_thread::yield();
      }
    });
  }
  int held = 0;
  while (held < 200 || handled < 1000) {
    const ReceiveLock::Pause pause{receive_lock};
    if (!pause.holds()) continue;
    ++held;
    const std::uint64_t before = handled;
    EXPECT_EQ(inside, 0);
    std::this_thread::yield();
    EXPECT_EQ(handled, before);
  }
  end = true;
  for (std::thread& receiver : receivers) receiver.join();
}

TEST(ReceiveLock, DoesNotPauseOnTheThreadThatHandlesAPacket) {
  ReceiveLock receive_lock;
  bool held = true;
  receive_lock.handle([&] { held = ReceiveLock::Pause{receive_lock}.holds(); });
  EXPECT_FALSE(held);
  EXPECT_TRUE(ReceiveLock::Pause{receive_lock}.holds());
}

TEST(ReceiveLock, ReportsAFailedPauseIfAPacketTakesTooLong) {
  ReceiveLock receive_lock;
  std::atomic<bool> handles{false};
  std::atomic<bool> end{false};
  std::thread receiver{[&] {
    receive_lock.handle([&] {
      handles = true;
      while (!end) std::this_thread::yield();
    });
  }};
  while (!handles) std::this_thread::yield();
  EXPECT_FALSE(ReceiveLock::Pause{receive_lock}.holds());
  end = true;
  receiver.join();
}

}  // namespace
}  // namespace receive_lock_test
