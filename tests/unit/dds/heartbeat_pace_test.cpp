// Tests how often a writer repeats a heartbeat or a sample, and a reader the request for its first heartbeat.
#include "workarounds/heartbeat_pace.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <deque>
#include <vector>

namespace heartbeat_pace_test {
namespace {

using takt::Instant;
using takt::Nanoseconds;
using takt::dds::FirstRequestPace;
using takt::dds::HeartbeatPace;
using takt::dds::ResendPace;

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr milliseconds kPeriod{5};

/// Asks every `period`, as Fast DDS does, from `begin` to `end`. The reader answers after `delay`. Every
/// `sample_every`, the writer writes a sample. Returns the number of heartbeats.
int heartbeats(HeartbeatPace& pace, Nanoseconds begin, Nanoseconds end, Nanoseconds delay,
               Nanoseconds sample_every = seconds{1000}, int lost_of_three = 0) {
  std::deque<Nanoseconds> answers;
  int count = 0;
  for (Nanoseconds now = begin; now < end; now += kPeriod) {
    while (!answers.empty() && answers.front() <= now) {
      pace.answered(Instant{answers.front()});
      answers.pop_front();
    }
    if (!pace.is_due(Instant{now}, kPeriod, static_cast<std::uint64_t>(now / sample_every) + 1)) continue;
    ++count;
    if (count % 3 >= lost_of_three) answers.push_back(now + delay);
  }
  return count;
}

TEST(HeartbeatPace, SendsOneInEachPeriodToAReaderThatAnswersAtOnce) {
  HeartbeatPace pace;
  EXPECT_EQ(heartbeats(pace, seconds{0}, seconds{1}, milliseconds{1}), 200);
}

TEST(HeartbeatPace, SendsFewToAReaderWhoseAnswersTakeLong) {
  HeartbeatPace pace;
  EXPECT_LE(heartbeats(pace, seconds{0}, seconds{1}, milliseconds{200}), 12) << "before the delay is known";
  EXPECT_LE(heartbeats(pace, seconds{1}, seconds{11}, milliseconds{200}), 50) << "5 a second";
}

TEST(HeartbeatPace, KnowsTheDelayFromTheFirstAnswer) {
  HeartbeatPace pace;
  heartbeats(pace, seconds{0}, milliseconds{605}, milliseconds{600});
  EXPECT_EQ(pace.round_trip(), milliseconds{600});
}

TEST(HeartbeatPace, BeginsWithTheRoundTripOfAnotherWriter) {
  HeartbeatPace first;
  heartbeats(first, seconds{0}, seconds{5}, milliseconds{200});
  HeartbeatPace second{first.round_trip()};
  EXPECT_LE(heartbeats(second, seconds{5}, seconds{6}, milliseconds{200}), 6) << "from the first on";
}

TEST(HeartbeatPace, NewSamplesCauseNoMoreHeartbeatsOnceTheDelayIsKnown) {
  HeartbeatPace pace;
  heartbeats(pace, seconds{0}, seconds{5}, milliseconds{200}, milliseconds{100});
  EXPECT_LE(heartbeats(pace, seconds{5}, seconds{15}, milliseconds{200}, milliseconds{100}), 100);
}

TEST(HeartbeatPace, AnswersThatAreLostDelayTheNextHeartbeatByAtMostFiftyMilliseconds) {
  HeartbeatPace pace;
  EXPECT_GE(heartbeats(pace, seconds{0}, seconds{10}, milliseconds{1}, seconds{1000}, 2), 200);
}

TEST(HeartbeatPace, RepeatsAnUnansweredHeartbeatAtLeastEvery200Milliseconds) {
  HeartbeatPace pace;
  EXPECT_GE(heartbeats(pace, seconds{0}, seconds{10}, seconds{1000}), 10 * 5);
}

TEST(HeartbeatPace, ReturnsToThePeriodWhenAnswersArriveSoonAgain) {
  HeartbeatPace pace;
  heartbeats(pace, seconds{0}, seconds{10}, milliseconds{300});
  heartbeats(pace, seconds{11}, seconds{16}, milliseconds{1});
  EXPECT_GE(heartbeats(pace, seconds{16}, seconds{17}, milliseconds{1}), 195);
}

/// A reader answers each heartbeat at once, and requests the same sample for ever. Returns when the writer
/// sends heartbeats, in ms.
std::vector<int> heartbeats_to_a_stuck_reader(ResendPace& resends, int end) {
  HeartbeatPace pace;
  std::vector<int> sent;
  for (int ms = 0; ms < end; ms += 5) {
    const Instant now{milliseconds{ms}};
    const auto newest = static_cast<std::uint64_t>(ms / 100);  // the writer goes on writing
    if (resends.is_paused(now, kPeriod / 2) || !pace.is_due(now, kPeriod, newest)) continue;
    sent.push_back(ms);
    pace.answered(now);
    EXPECT_TRUE(resends.is_due(now, 7)) << "each heartbeat causes an answer after " << ms << " ms";
  }
  return sent;
}

TEST(ResendPace, SlowsTheHeartbeatsToAReaderThatIsStuckToOneASecond) {
  ResendPace resends;
  EXPECT_EQ(heartbeats_to_a_stuck_reader(resends, 5000),
            (std::vector<int>{0, 10, 30, 70, 150, 310, 630, 1270, 2270, 3270, 4270}));
  EXPECT_TRUE(resends.is_stuck(Instant{seconds{5}}));
}

TEST(ResendPace, BeginsAgainWhenTheReaderHasReceivedSomething) {
  ResendPace resends;
  heartbeats_to_a_stuck_reader(resends, 5000);
  const Instant now{seconds{5}};
  EXPECT_TRUE(resends.is_due(now, 8));
  EXPECT_FALSE(resends.is_stuck(now));
  EXPECT_TRUE(resends.is_paused(now + milliseconds{9}, {}));
  EXPECT_FALSE(resends.is_paused(now + milliseconds{10}, {}));
}

TEST(ResendPace, PausesNothingThatWasNotRequested) {
  EXPECT_FALSE(ResendPace{}.is_paused(Instant{seconds{1}}, {}));
}

TEST(FirstRequestPace, DoublesThePauseUpToALimit) {
  FirstRequestPace pace;
  std::vector<int> sent;
  for (int ms = 0; ms < 2000; ms += 10) {
    if (pace.is_due(Instant{milliseconds{ms}})) sent.push_back(ms);
  }
  EXPECT_EQ(sent, (std::vector<int>{0, 10, 30, 70, 150, 310, 630, 950, 1270, 1590, 1910}));
}

TEST(FirstRequestPace, BeginsAgainForAWriterThatIsFoundAgain) {
  FirstRequestPace pace;
  for (int ms = 0; ms < 2000; ms += 10) static_cast<void>(pace.is_due(Instant{milliseconds{ms}}));
  EXPECT_TRUE(pace.is_due(Instant{seconds{10}}));
  EXPECT_TRUE(pace.is_due(Instant{seconds{10} + milliseconds{10}}));
}

}  // namespace
}  // namespace heartbeat_pace_test
