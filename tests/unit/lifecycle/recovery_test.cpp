#include <takt/lifecycle/recovery.hpp>

#include <gtest/gtest.h>

namespace takt::lifecycle::recovery_test {
namespace {

using namespace std::chrono_literals;
using Step = Recovery::Step;

constexpr Instant at(Nanoseconds t) { return Instant{t}; }

TEST(Recovery, WaitsForTheBackoffBeforeEachAttempt) {
  Recovery recovery{{.attempts = 2, .backoff = 100ms}};
  recovery.failed(at(1s));
  EXPECT_EQ(recovery.next(at(1s + 99ms)), Step::wait);
  EXPECT_EQ(recovery.next(at(1s + 100ms)), Step::attempt);
  recovery.attempted(at(1s + 100ms), false);
  EXPECT_EQ(recovery.next(at(1s + 150ms)), Step::wait);
  EXPECT_EQ(recovery.next(at(1s + 200ms)), Step::attempt);
  recovery.attempted(at(1s + 200ms), false);
  EXPECT_EQ(recovery.next(at(1s + 200ms)), Step::give_up);
}

TEST(Recovery, GivesUpAtOnceIfNoAttemptsAreAllowed) {
  Recovery recovery{{.attempts = 0, .backoff = 100ms}};
  recovery.failed(at(0s));
  EXPECT_EQ(recovery.next(at(0s)), Step::give_up);
}

TEST(Recovery, DoesNotCountAnAttemptAfterAnErrorThatEndedByItself) {
  Recovery recovery{{.attempts = 1, .backoff = 100ms}};
  Nanoseconds now = 1s;
  for (int i = 0; i < 5; ++i) {
    recovery.failed(at(now));
    EXPECT_EQ(recovery.next(at(now), false), Step::wait);
    now += 100ms;
    ASSERT_EQ(recovery.next(at(now), false), Step::attempt) << i;
    recovery.attempted(at(now), true);
    EXPECT_EQ(recovery.attempts(), 0);
  }
  recovery.failed(at(now));
  EXPECT_EQ(recovery.next(at(now + 1s)), Step::attempt);
  recovery.attempted(at(now + 1s), false);
  EXPECT_EQ(recovery.next(at(now + 2s)), Step::give_up);
  Recovery none{{.attempts = 0, .backoff = 100ms}};
  none.failed(at(1s));
  EXPECT_EQ(none.next(at(2s), false), Step::give_up);
}

TEST(Recovery, KeepsCountingAttemptsIfASuccessDoesNotLast) {
  Recovery recovery{{.attempts = 3, .backoff = 10ms}};
  Nanoseconds now = 5s;
  for (int i = 0; i < 3; ++i) {
    recovery.failed(at(now));
    now += 10ms;
    ASSERT_EQ(recovery.next(at(now)), Step::attempt) << i;
    recovery.attempted(at(now), true);
    now += 500ms;
  }
  recovery.failed(at(now));
  EXPECT_EQ(recovery.next(at(now + 1h)), Step::give_up);
}

TEST(Recovery, ResetsTheAttemptCountAfterALastingSuccess) {
  Recovery recovery{{.attempts = 1, .backoff = 10ms}};
  Nanoseconds now = 5s;
  for (int i = 0; i < 10; ++i) {
    recovery.failed(at(now));
    now += 10ms;
    ASSERT_EQ(recovery.next(at(now)), Step::attempt) << i;
    recovery.attempted(at(now), true);
    now += 1s;
  }
}

TEST(Recovery, DoesNotCountTimeInAHangAsSuccess) {
  Recovery recovery{{.attempts = 1, .backoff = 10ms}};
  recovery.failed(at(5s));
  ASSERT_EQ(recovery.next(at(6s)), Step::attempt);
  recovery.attempted(at(6s), true);
  recovery.failed(at(9s), at(6s + 100ms));
  EXPECT_EQ(recovery.next(at(10s)), Step::give_up);
}

}  // namespace
}  // namespace takt::lifecycle::recovery_test
