#include <takt/dds/unauthenticated_participants.hpp>

#include <gtest/gtest.h>

namespace takt::dds::newcomers_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kHere = 1;
constexpr std::uint32_t kThere = 2;
constexpr std::uint32_t kLease = 10;  // s

class NewcomersTest : public testing::Test {
 protected:
  static ParticipantNumber number(std::size_t n) {
    return {static_cast<std::uint8_t>(n >> 16U), static_cast<std::uint8_t>(n >> 8U),
            static_cast<std::uint8_t>(n)};
  }
  bool admit(std::size_t n, std::uint32_t address, std::uint32_t lease = kLease,
             Announcement::Of of = Announcement::Of::sender) {
    return newcomers_.admit({.of = of, .number = number(n), .lease_s = lease}, address, now_);
  }
  /// As many as there may be, from 0 on.
  void fill(std::uint32_t address, std::size_t from = 0) {
    for (std::size_t n = 0; n < UnauthenticatedParticipants::kOfOneAddress; ++n)
      ASSERT_TRUE(admit(from + n, address)) << n;
    ASSERT_FALSE(admit(from + UnauthenticatedParticipants::kOfOneAddress, address));
  }

  UnauthenticatedParticipants newcomers_;
  UnauthenticatedParticipants::Clock::time_point now_{1h};
};

TEST_F(NewcomersTest, SpeakForThemselvesAndNotForEver) {
  EXPECT_FALSE(admit(1, kHere, kLease, Announcement::Of::other));
  EXPECT_FALSE(admit(1, kHere, UnauthenticatedParticipants::kLongestLease + 1));
  EXPECT_FALSE(admit(1, kHere, 0));
  EXPECT_TRUE(admit(1, kHere, UnauthenticatedParticipants::kLongestLease));
  EXPECT_FALSE(admit(1, kHere, ~0U)) << "nor later";
}

TEST_F(NewcomersTest, AreNoMoreOfOneAddressThanItMayHave) {
  fill(kHere);
  EXPECT_TRUE(admit(0, kHere)) << "one that is known may say so again";
  EXPECT_TRUE(admit(0, kThere)) << "wherever from";
  EXPECT_TRUE(admit(10'000, kThere)) << "another address has its own";
}

TEST_F(NewcomersTest, WhoProvedHimselfMakesRoom) {
  fill(kHere);
  newcomers_.proved(number(0));
  newcomers_.proved(number(0));
  EXPECT_TRUE(admit(10'000, kHere));
  EXPECT_FALSE(admit(10'001, kHere)) << "for one";
  EXPECT_TRUE(admit(0, kHere));
  newcomers_.left(number(0));
  EXPECT_FALSE(admit(10'001, kHere)) << "he took none any more";
  EXPECT_FALSE(admit(0, kHere)) << "and is a newcomer again";
  newcomers_.left(number(77'777));
  newcomers_.proved(number(77'777));
}

TEST_F(NewcomersTest, WhoComesAndGoesTakesAPlace) {
  for (std::size_t n = 0; n < UnauthenticatedParticipants::kOfOneAddress; ++n) {
    ASSERT_TRUE(admit(n, kHere, 1)) << n;
    newcomers_.left(number(n));
  }
  EXPECT_FALSE(admit(10'000, kHere));
  now_ += std::chrono::seconds{UnauthenticatedParticipants::kShortestStay};
  EXPECT_TRUE(admit(10'000, kHere));
}

TEST_F(NewcomersTest, AreGoneWithoutAWord) {
  constexpr std::uint32_t kLong = 30;  // s
  for (std::size_t n = 0; n < UnauthenticatedParticipants::kOfOneAddress; ++n)
    ASSERT_TRUE(admit(n, kHere, kLong)) << n;
  now_ += 15s;
  EXPECT_TRUE(admit(0, kHere, kLong));
  now_ += 15s;
  EXPECT_FALSE(admit(10'000, kHere));
  now_ += 1s;
  EXPECT_TRUE(admit(10'000, kHere)) << "all but the one that said so again";
  for (std::size_t n = 2; n < UnauthenticatedParticipants::kOfOneAddress; ++n)
    EXPECT_TRUE(admit(10'000 + n, kHere)) << n;
  EXPECT_FALSE(admit(20'000, kHere));
}

TEST_F(NewcomersTest, AreNoMoreInAllThanThereMayBe) {
  constexpr std::size_t kAddresses =
      UnauthenticatedParticipants::kInAll / UnauthenticatedParticipants::kOfOneAddress;
  for (std::size_t address = 0; address < kAddresses; ++address)
    fill(static_cast<std::uint32_t>(address), address * UnauthenticatedParticipants::kOfOneAddress * 2);
  EXPECT_FALSE(admit(99'999, 99));
  newcomers_.proved(number(0));
  EXPECT_TRUE(admit(99'999, 99));
}

}  // namespace
}  // namespace takt::dds::newcomers_test
