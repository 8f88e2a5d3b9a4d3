#include <takt/os/waker.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>
#include <vector>

#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>

namespace takt::os::waker_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

TEST(WakeMargin, StartsAtItsCap) { EXPECT_EQ(WakeMargin{microseconds{40}}.value(), microseconds{40}); }

TEST(WakeMargin, NeverExceedsItsCap) {
  WakeMargin margin{microseconds{40}};
  for (int i = 0; i < 10'000; ++i) {
    margin.observe(milliseconds{5});
    ASSERT_LE(margin.value(), microseconds{40});
  }
}

TEST(WakeMargin, StaysAt1MicrosecondIfEveryWakeUpIsPunctual) {
  WakeMargin margin{microseconds{40}};
  for (int i = 0; i < 100'000; ++i) margin.observe(Nanoseconds{0});
  EXPECT_EQ(margin.value(), microseconds{1});
}

TEST(WakeMargin, IsZeroIfTheCapIsZero) {
  WakeMargin margin{Nanoseconds{0}};
  margin.observe(microseconds{5});
  margin.observe(Nanoseconds{0});
  EXPECT_EQ(margin.value(), Nanoseconds{0});
}

TEST(WakeMargin, SettlesAtThe99thPercentileOfTheDelays) {
  std::mt19937_64 random{5};
  std::lognormal_distribution<double> delay{std::log(8'000.0), 0.5};  // the median delay is 8 us
  WakeMargin margin{microseconds{100}};
  for (int i = 0; i < 200'000; ++i) margin.observe(Nanoseconds{static_cast<std::int64_t>(delay(random))});
  int beyond = 0;
  constexpr int kMore = 200'000;
  for (int i = 0; i < kMore; ++i) {
    const Nanoseconds d{static_cast<std::int64_t>(delay(random))};
    if (d > margin.value()) ++beyond;
    margin.observe(d);
  }
  EXPECT_NEAR(beyond, kMore / 100, kMore / 1000);
  const double exact = 8'000 * std::exp(0.5 * 2.326);
  EXPECT_NEAR(static_cast<double>(margin.value().count()), exact, 0.15 * exact);
}

TEST(WakeMargin, ShrinksWhenDelaysGetShorter) {
  WakeMargin margin{microseconds{100}};
  for (int i = 0; i < 20'000; ++i) margin.observe(microseconds{3});
  EXPECT_LT(margin.value(), microseconds{5});
  EXPECT_GT(margin.value(), microseconds{2});
}

TEST(MarginCap, IsAShareOfThePeriodAndAtMost100Microseconds) {
  EXPECT_EQ(margin_cap(microseconds{100}, 0.4), microseconds{40});
  EXPECT_EQ(margin_cap(microseconds{100}, 0.05), microseconds{5});
  EXPECT_EQ(margin_cap(milliseconds{1}, 0.4), microseconds{100});
  EXPECT_EQ(margin_cap(Nanoseconds{1}, 0.4), Nanoseconds{0});
  EXPECT_EQ(margin_cap(milliseconds{1}, 0), Nanoseconds{0});
}

class EachWaker : public testing::TestWithParam<model::Wakeup> {
 protected:
  std::atomic<std::uint32_t> stop{0};
  Waker waker{GetParam(), microseconds{100}, stop};
};

TEST_P(EachWaker, NeverReturnsEarly) {
  for (int i = 0; i < 100; ++i) {
    const Instant release = now() + microseconds{i * 10};
    EXPECT_GE(waker.wait_until(release), release);
    EXPECT_GE(now(), release);
  }
}

TEST_P(EachWaker, ReturnsAtOnceIfTheReleaseTimeHasPassed) {
  const Instant before = now();
  const Instant woke = waker.wait_until(before - seconds{100});
  EXPECT_GE(woke, before);
  EXPECT_LT(woke, before + seconds{50});
}

TEST_P(EachWaker, ReturnsEarlyWhenStopped) {
  const Instant release = now() + seconds{100};
  std::thread stopper{[this] {
    sleep_until(now() + milliseconds{5});
    stop.store(1);
    futex_wake(stop, ~0U);
  }};
  EXPECT_LT(waker.wait_until(release), release - seconds{50});
  stopper.join();
  EXPECT_LT(waker.wait_until(release), release - seconds{50}) << "a stopped waker does not wait again";
}

TEST_P(EachWaker, ContinuesToSleepAfterASpuriousWakeUp) {
  const Instant release = now() + milliseconds{20};
  std::atomic<bool> end{false};
  std::thread waking{[&] {
    while (!end) {
      futex_wake(stop, ~0U);
      std::this_thread::yield();
    }
  }};
  EXPECT_GE(waker.wait_until(release), release);
  end = true;
  waking.join();
}

INSTANTIATE_TEST_SUITE_P(Strategies, EachWaker,
                         testing::Values(model::Wakeup::sleep, model::Wakeup::hybrid, model::Wakeup::spin),
                         [](const auto& each) { return std::string{to_text(each.param)}; });

TEST(Waker, HasNoMarginIfItOnlySleeps) {
  const std::atomic<std::uint32_t> stop{0};
  EXPECT_EQ((Waker{model::Wakeup::sleep, microseconds{70}, stop}.margin()), Nanoseconds{0});
  EXPECT_EQ((Waker{model::Wakeup::hybrid, microseconds{70}, stop}.margin()), microseconds{70});
}

}  // namespace
}  // namespace takt::os::waker_test
