#include <takt/agent/clock_offset.hpp>

#include <gtest/gtest.h>

#include <limits>

namespace takt::agent::clock_offset_test {
namespace {

using std::chrono::hours;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

/// Two nodes on virtual time. The test sets how long a message takes from one node to the other: `there` and
/// `back`.
struct TwoNodes {
  static constexpr std::int64_t kWallAtZero = 1'700'000'000'000'000'000;

  /// The true offset: the wall clock of the other node minus the monotonic clock of this node.
  [[nodiscard]] std::int64_t truth() const { return kWallAtZero + ahead.count(); }
  /// This node sends its status, and the other node answers it after `held`.
  void exchange(Nanoseconds held = milliseconds{60}) {
    const Instant sent = now;
    now += there + held;
    const std::int64_t wall_ns = to_ns(now) + truth();
    now += back;
    offset.heard(wall_ns, now);
    offset.answered(wall_ns, sent, held, now);
  }
  /// A status of the other node arrives that contains no answer.
  void hear() {
    const std::int64_t wall_ns = to_ns(now) + truth();
    now += back;
    offset.heard(wall_ns, now);
  }
  void expect_truth_within(Nanoseconds width) const {
    const auto bounds = offset.at(now);
    ASSERT_TRUE(bounds);
    EXPECT_LE(bounds->low_ns, truth());
    EXPECT_GE(bounds->high_ns, truth());
    EXPECT_LE(bounds->high_ns - bounds->low_ns, width.count());
  }

  Instant now = from_ns(5'000'000'000);
  Nanoseconds ahead{0};
  Nanoseconds there = microseconds{200};
  Nanoseconds back = microseconds{200};
  ClockOffset offset;
};

TEST(ClockOffset, IsNotKnownBeforeTheFirstAnswer) {
  TwoNodes nodes;
  EXPECT_FALSE(nodes.offset.at(nodes.now));
  nodes.hear();
  EXPECT_FALSE(nodes.offset.at(nodes.now));
}

TEST(ClockOffset, IsKnownWithAnUncertaintyOfAtMostTheRoundTripTime) {
  for (const Nanoseconds ahead :
       {Nanoseconds{0}, Nanoseconds{milliseconds{500}}, Nanoseconds{seconds{-30}}}) {
    TwoNodes nodes;
    nodes.ahead = ahead;
    nodes.there = milliseconds{5};
    nodes.back = microseconds{100};
    nodes.exchange();
    nodes.expect_truth_within(nodes.there + nodes.back);
  }
}

TEST(ClockOffset, NeverMakesASampleSeemYoungerThanItIs) {
  TwoNodes nodes;
  nodes.ahead = milliseconds{500};
  for (const milliseconds delay : {milliseconds{300}, milliseconds{1}, milliseconds{40}}) {
    nodes.there = delay;
    nodes.back = milliseconds{300};
    for (int i = 0; i < 5; ++i) nodes.exchange();
    const std::int64_t sent_wall = to_ns(nodes.now) + nodes.truth();
    nodes.now += milliseconds{310};
    const std::int64_t sent = sent_wall - nodes.offset.at(nodes.now)->high_ns;
    EXPECT_GE(to_ns(nodes.now) - sent, 310'000'000) << "the age of a sample that is 310 ms old";
    EXPECT_LE(to_ns(nodes.now) - sent, 310'000'000 + Nanoseconds{delay}.count() + 1'000'000);
  }
}

TEST(ClockOffset, KeepsTheBoundsOfAFastExchangeWhenLaterOnesAreSlow) {
  TwoNodes nodes;
  nodes.exchange();
  nodes.there = milliseconds{50};
  nodes.exchange();
  nodes.expect_truth_within(milliseconds{1});
}

TEST(ClockOffset, WidensTheBoundsWithTimeBecauseClocksDrift) {
  TwoNodes nodes;
  nodes.exchange();
  nodes.now += seconds{100};
  nodes.ahead += milliseconds{40};  // 400 ppm
  nodes.expect_truth_within(milliseconds{101});
  nodes.exchange();
  nodes.expect_truth_within(milliseconds{1});
}

TEST(ClockOffset, FollowsAClockThatIsSet) {
  for (const Nanoseconds step : {Nanoseconds{hours{1}}, Nanoseconds{hours{-1}}, Nanoseconds{milliseconds{20}},
                                 Nanoseconds{milliseconds{-20}}}) {
    TwoNodes nodes;
    nodes.exchange();
    nodes.ahead += step;
    nodes.exchange();
    nodes.expect_truth_within(milliseconds{1});
  }
}

TEST(ClockOffset, FollowsASmallStepOfTheOtherClockOnASlowNetwork) {
  for (const milliseconds step :
       {milliseconds{500}, milliseconds{100}, milliseconds{-100}, milliseconds{-500}}) {
    TwoNodes nodes;
    nodes.there = nodes.back = milliseconds{300};
    for (int i = 0; i < 5; ++i) nodes.exchange();
    nodes.ahead += step;
    nodes.back = milliseconds{320};
    for (int i = 0; i < 5; ++i) {
      nodes.exchange();
      nodes.expect_truth_within(milliseconds{621});
    }
  }
}

TEST(ClockOffset, IsNotKnownAfterTheClockWasSetForwardUntilTheNextAnswer) {
  TwoNodes nodes;
  nodes.exchange();
  nodes.ahead += seconds{1};
  nodes.hear();
  EXPECT_FALSE(nodes.offset.at(nodes.now));
  nodes.exchange();
  nodes.expect_truth_within(milliseconds{1});
}

TEST(ClockOffset, IgnoresImpossibleAnswers) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kLeast = std::numeric_limits<std::int64_t>::min();
  TwoNodes nodes;
  const std::int64_t wall_ns = to_ns(nodes.now) + nodes.truth();
  const Instant sent = nodes.now - milliseconds{1};
  for (const std::int64_t wall : {kMost, kLeast, std::int64_t{-1}})
    nodes.offset.answered(wall, sent, milliseconds{0}, nodes.now);
  for (const std::int64_t at : {kMost, kLeast, to_ns(nodes.now) + 1})
    nodes.offset.answered(wall_ns, from_ns(at), milliseconds{0}, nodes.now);
  for (const std::int64_t held : {kMost, kLeast, std::int64_t{2'000'000}})  // 2 ms: longer than since sent
    nodes.offset.answered(wall_ns, sent, Nanoseconds{held}, nodes.now);
  EXPECT_FALSE(nodes.offset.at(nodes.now));
  nodes.exchange();
  nodes.offset.heard(kMost, nodes.now);
  nodes.offset.heard(kLeast, nodes.now);
  nodes.expect_truth_within(milliseconds{1});
}

}  // namespace
}  // namespace takt::agent::clock_offset_test
