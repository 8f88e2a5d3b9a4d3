#include <takt/dds/handling.hpp>

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

namespace handling_test {
namespace {

using takt::dds::Handling;

TEST(Handling, StandsStillWhileItIsPaused) {
  Handling handling;
  std::atomic<int> inside{0};
  std::atomic<std::uint64_t> handled{0};
  std::atomic<bool> end{false};
  std::vector<std::thread> receivers;
  for (int i = 0; i < 2; ++i) {
    receivers.emplace_back([&] {
      while (!end) {
        handling.handle([&] {
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
    const Handling::Pause pause{handling};
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

TEST(Handling, IsNotWaitedForByTheThreadThatHandles) {
  Handling handling;
  bool held = true;
  handling.handle([&] { held = Handling::Pause{handling}.holds(); });
  EXPECT_FALSE(held);
  EXPECT_TRUE(Handling::Pause{handling}.holds());
}

TEST(Handling, IsNotWaitedForForEver) {
  Handling handling;
  std::atomic<bool> handles{false};
  std::atomic<bool> end{false};
  std::thread receiver{[&] {
    handling.handle([&] {
      handles = true;
      while (!end) std::this_thread::yield();
    });
  }};
  while (!handles) std::this_thread::yield();
  EXPECT_FALSE(Handling::Pause{handling}.holds());
  end = true;
  receiver.join();
}

}  // namespace
}  // namespace handling_test
