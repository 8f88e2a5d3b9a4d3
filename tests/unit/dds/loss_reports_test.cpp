#include "loss_reports.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

namespace takt::dds::loss_reports_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using Numbers = std::vector<wire::ParticipantNumber>;

constexpr wire::ParticipantNumber kRobot{1};
constexpr wire::ParticipantNumber kLine{2};
constexpr os::UdpEnd kAt{{10, 0, 0, 1}, 7410};

class Reports : public ::testing::Test {
 protected:
  void after(Nanoseconds time) { now_ += time; }
  Numbers due() {
    Numbers numbers;
    for (const auto& [number, at] : reports_.due(now_)) {
      EXPECT_EQ(at.address, kAt.address);
      EXPECT_EQ(at.port, kAt.port);
      numbers.push_back(number);
    }
    return numbers;
  }
  /// The participant announces itself each second, and due() is called each time.
  std::size_t reports_within(int count, const wire::ParticipantNumber& participant) {
    std::size_t number = 0;
    for (int i = 0; i < count; ++i) {
      reports_.announced(participant, kAt, now_);
      number += due().size();
      after(seconds{1});
    }
    return number;
  }
  Numbers reported(std::optional<Instant> heard = std::nullopt) {
    reports_.reported(kRobot, heard, now_);
    return reports_.take_mutual();
  }

  LossReports reports_;
  Instant now_{seconds{1000}};
};

TEST_F(Reports, AreSentWhileALostMemberAnnouncesItselfButDoesNotAuthenticate) {
  reports_.authenticated(kRobot, now_);
  EXPECT_EQ(reports_within(5, kRobot), 0U) << "it is not lost";
  reports_.lost(kRobot);
  after(seconds{10});
  EXPECT_EQ(due(), Numbers{}) << "nobody knows where it is";
  EXPECT_EQ(reports_within(3, kRobot), 0U) << "the authentication takes some time";
  EXPECT_EQ(reports_within(5, kRobot), 5U);
  after(seconds{3});
  EXPECT_EQ(due(), Numbers{}) << "it has ended";
  EXPECT_EQ(reports_within(3, kRobot), 0U) << "it announces itself again";
  EXPECT_EQ(reports_within(1, kRobot), 1U);
  reports_.authenticated(kRobot, now_);
  EXPECT_EQ(reports_within(5, kRobot), 0U);
}

TEST_F(Reports, AreSentOnlyToMembers) {
  reports_.lost(kLine);
  EXPECT_EQ(reports_within(10, kLine), 0U);
}

TEST_F(Reports, AreSentOncePerSecond) {
  reports_.authenticated(kRobot, now_);
  reports_.lost(kRobot);
  reports_within(3, kRobot);
  reports_.announced(kRobot, kAt, now_);
  EXPECT_EQ(due(), Numbers{kRobot});
  after(milliseconds{900});
  EXPECT_EQ(due(), Numbers{});
  after(milliseconds{100});
  EXPECT_EQ(due(), Numbers{kRobot});
}

TEST_F(Reports, AreBelievedIfTheyAreRepeatedForTwoSeconds) {
  reports_.authenticated(kRobot, now_);
  after(seconds{5});
  EXPECT_EQ(reported(), Numbers{});
  after(seconds{1});
  EXPECT_EQ(reported(), Numbers{});
  after(seconds{1});
  EXPECT_EQ(reported(), Numbers{kRobot});
  EXPECT_EQ(reported(), Numbers{}) << "once";
}

TEST_F(Reports, AreNotBelievedIfTheirSenderStillSendsEncryptedMessages) {
  reports_.authenticated(kRobot, now_);
  after(seconds{5});
  const Instant before = now_ - seconds{1};
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(reported(before), Numbers{});
    after(seconds{1});
  }
  Instant heard = now_ - milliseconds{500};
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(reported(heard), Numbers{});
    after(seconds{1});
  }
  EXPECT_EQ(reported(heard), Numbers{kRobot}) << "it has been silent for two seconds";
}

TEST_F(Reports, AreNotBelievedIfSomeOfThemAreMissing) {
  reports_.authenticated(kRobot, now_);
  after(seconds{5});
  EXPECT_EQ(reported(), Numbers{});
  after(seconds{3});
  EXPECT_EQ(reported(), Numbers{}) << "this may be the first of a new series";
}

TEST_F(Reports, AreNotBelievedDirectlyAfterTheAuthenticationNorFromStrangers) {
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(reported(), Numbers{});
    after(seconds{1});
  }
  reports_.authenticated(kRobot, now_);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(reported(), Numbers{});
    after(seconds{1});
  }
}

}  // namespace
}  // namespace takt::dds::loss_reports_test
