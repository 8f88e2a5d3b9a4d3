#include <takt/wire/unauthenticated_participants.hpp>

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace takt::wire::unauthenticated_participants_test {
namespace {

using namespace std::chrono_literals;

constexpr std::uint32_t kHere = 1;
constexpr std::uint32_t kThere = 2;
constexpr std::uint32_t kLease = 10;  // seconds

class UnauthenticatedPeers : public testing::Test {
 protected:
  static ParticipantNumber number(std::size_t n) {
    return {static_cast<std::uint8_t>(n >> 16U), static_cast<std::uint8_t>(n >> 8U),
            static_cast<std::uint8_t>(n)};
  }
  bool admit(std::size_t n, std::uint32_t address, std::uint32_t lease = kLease,
             Announcement::Of of = Announcement::Of::sender) {
    return unauthenticated_.admit({.of = of, .number = number(n), .lease_s = lease}, address, now_);
  }
  /// Fills all slots of an address with participants. The number of the first participant is `from`.
  void fill(std::uint32_t address, std::size_t from = 0) {
    for (std::size_t n = 0; n < UnauthenticatedParticipants::kOfOneAddress; ++n)
      ASSERT_TRUE(admit(from + n, address)) << n;
    ASSERT_FALSE(admit(from + UnauthenticatedParticipants::kOfOneAddress, address));
  }

  UnauthenticatedParticipants unauthenticated_;
  UnauthenticatedParticipants::Clock::time_point now_{1h};
};

TEST_F(UnauthenticatedPeers, MustAnnounceThemselvesWithALimitedLease) {
  EXPECT_FALSE(admit(1, kHere, kLease, Announcement::Of::other));
  EXPECT_FALSE(admit(1, kHere, UnauthenticatedParticipants::kLongestLease + 1));
  EXPECT_FALSE(admit(1, kHere, 0));
  EXPECT_TRUE(admit(1, kHere, UnauthenticatedParticipants::kLongestLease));
  EXPECT_FALSE(admit(1, kHere, ~0U)) << "the limit also applies to a known participant";
}

TEST_F(UnauthenticatedPeers, AreLimitedPerAddress) {
  fill(kHere);
  EXPECT_TRUE(admit(0, kHere)) << "a known participant may announce itself again";
  EXPECT_TRUE(admit(0, kThere)) << "and may do so from any address";
  EXPECT_TRUE(admit(10'000, kThere)) << "another address has its own slots";
}

TEST_F(UnauthenticatedPeers, FreeTheirSlotWhenTheyAuthenticate) {
  fill(kHere);
  unauthenticated_.authenticated(number(0));
  unauthenticated_.authenticated(number(0));
  EXPECT_TRUE(admit(10'000, kHere));
  EXPECT_FALSE(admit(10'001, kHere)) << "only one slot was freed";
  EXPECT_TRUE(admit(0, kHere));
  unauthenticated_.left(number(0));
  EXPECT_FALSE(admit(10'001, kHere)) << "an authenticated participant takes no slot";
  EXPECT_FALSE(admit(0, kHere)) << "after leaving, it counts as unauthenticated again";
  unauthenticated_.left(number(77'777));
  unauthenticated_.authenticated(number(77'777));
}

TEST_F(UnauthenticatedPeers, KeepTheirSlotForAWhileAfterLeaving) {
  for (std::size_t n = 0; n < UnauthenticatedParticipants::kOfOneAddress; ++n) {
    ASSERT_TRUE(admit(n, kHere, 1)) << n;
    unauthenticated_.left(number(n));
  }
  EXPECT_FALSE(admit(10'000, kHere));
  now_ += std::chrono::seconds{UnauthenticatedParticipants::kShortestStay};
  unauthenticated_.remove_expired(now_);
  EXPECT_TRUE(admit(10'000, kHere));
}

TEST_F(UnauthenticatedPeers, ExpireWithTheirLease) {
  constexpr std::uint32_t kLong = 30;  // seconds
  for (std::size_t n = 0; n < UnauthenticatedParticipants::kOfOneAddress; ++n)
    ASSERT_TRUE(admit(n, kHere, kLong)) << n;
  now_ += 15s;
  EXPECT_TRUE(admit(0, kHere, kLong));
  now_ += 15s;
  EXPECT_TRUE(unauthenticated_.remove_expired(now_).empty());
  EXPECT_FALSE(admit(10'000, kHere));
  now_ += 1s;
  unauthenticated_.authenticated(number(1));
  const std::vector<ParticipantNumber> expired = unauthenticated_.remove_expired(now_);
  EXPECT_EQ(expired.size(), UnauthenticatedParticipants::kOfOneAddress - 1) << "also the authenticated one";
  EXPECT_EQ(std::ranges::count(expired, number(0)), 0);
  EXPECT_TRUE(admit(10'000, kHere)) << "all expired except the one that announced itself again";
  for (std::size_t n = 2; n < UnauthenticatedParticipants::kOfOneAddress; ++n)
    EXPECT_TRUE(admit(10'000 + n, kHere)) << n;
  EXPECT_FALSE(admit(20'000, kHere));
}

TEST_F(UnauthenticatedPeers, AreLimitedInTotal) {
  constexpr std::size_t kAddresses =
      UnauthenticatedParticipants::kInAll / UnauthenticatedParticipants::kOfOneAddress;
  for (std::size_t address = 0; address < kAddresses; ++address)
    fill(static_cast<std::uint32_t>(address), address * UnauthenticatedParticipants::kOfOneAddress * 2);
  EXPECT_FALSE(admit(99'999, 99));
  unauthenticated_.authenticated(number(0));
  EXPECT_TRUE(admit(99'999, 99));
}

}  // namespace
}  // namespace takt::wire::unauthenticated_participants_test
