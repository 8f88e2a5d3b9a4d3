#include "host_names.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace takt::dds::host_names_test {
namespace {

using os::Ipv4;
using std::chrono::seconds;
using Addresses = std::vector<Ipv4>;
using Texts = std::vector<std::string>;

constexpr Ipv4 kOne{10, 0, 0, 1};
constexpr Ipv4 kTwo{10, 0, 0, 2};
constexpr Ipv4 kThree{10, 0, 0, 3};

/// Names, a name service that answers when the test says so, and a clock.
class Names : public ::testing::Test {
 protected:
  const std::shared_ptr<HostNames> names_ = std::make_shared<HostNames>(
      [this](const std::string& host, const os::FoundAddresses& found) { asked_.emplace(host, found); },
      [this](const std::string& text) { told_.push_back(text); });

  Texts asked() const {
    Texts hosts;
    for (const auto& [host, found] : asked_) hosts.push_back(host);
    return hosts;
  }
  /// Answers the look-up of this host.
  void answer(const std::string& host, const Result<Addresses>& result) {
    const auto found = asked_.find(host);
    ASSERT_NE(found, asked_.end()) << host << " is not being looked up";
    const os::FoundAddresses give = found->second;
    asked_.erase(found);
    give(result);
  }
  void after(Nanoseconds time) { names_->step(now_ += time); }

  std::multimap<std::string, os::FoundAddresses> asked_;
  Texts told_;
  Instant now_{seconds{1000}};
};

TEST_F(Names, LookUpNoAddress) {
  EXPECT_EQ(names_->add("peer", "10.0.0.1"), kOne);
  EXPECT_FALSE(HostNames::is_placeholder(kOne));
  after(seconds{0});
  EXPECT_EQ(asked(), Texts{});
  EXPECT_EQ(names_->unresolved(), "");
}

TEST_F(Names, LeadNowhereUntilTheyAreFound) {
  const Ipv4 north = names_->add("peer", "north");
  const Ipv4 south = names_->add("peer", "south");
  EXPECT_TRUE(HostNames::is_placeholder(north) && HostNames::is_placeholder(south));
  after(seconds{0});
  EXPECT_EQ(asked(), (Texts{"north", "south"}));
  EXPECT_EQ(names_->addresses(north), Addresses{});
  answer("south", Addresses{kTwo, kOne, kTwo});
  EXPECT_EQ(names_->addresses(north), Addresses{});
  EXPECT_EQ(names_->addresses(south), (Addresses{kOne, kTwo})) << "each address once";
  answer("north", Addresses{kThree});
  EXPECT_EQ(names_->addresses(north), Addresses{kThree});
  EXPECT_EQ(names_->addresses({240, 0, 0, 2}), Addresses{}) << "there are only two names";
}

TEST_F(Names, HaveDifferentPlaceholdersAlsoIfThereAreMany) {
  std::vector<Ipv4> placeholders;
  for (int i = 0; i < 300; ++i) placeholders.push_back(names_->add("peer", "n" + std::to_string(i)));
  after(seconds{0});
  for (int i = 0; i < 300; ++i) {
    const auto last = static_cast<std::uint8_t>(i % 250);
    answer("n" + std::to_string(i), Addresses{{10, 0, static_cast<std::uint8_t>(i / 250), last}});
    after(seconds{0});  // only a few are looked up at once
  }
  for (int i : {0, 255, 256, 299}) {
    const auto found = names_->addresses(placeholders[static_cast<std::size_t>(i)]);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0][2] * 250 + found[0][3], i);
  }
}

TEST_F(Names, AreLookedUpByAFewThreadsAtOnce) {
  for (int i = 0; i < 100; ++i) names_->add("peer", "n" + std::to_string(i));
  after(seconds{0});
  EXPECT_EQ(asked_.size(), 16U);
  after(seconds{60});
  EXPECT_EQ(asked_.size(), 16U) << "none of them has been answered";
  answer(asked_.begin()->first, fail("unknown"));
  after(seconds{0});
  EXPECT_EQ(asked_.size(), 16U);
}

TEST_F(Names, AreReportedOnceWhileTheyHaveNoAddressAndAgainWhenTheyHaveOne) {
  names_->add("peer", "north");
  after(seconds{0});
  EXPECT_EQ(names_->unresolved(), "peer 'north' cannot be resolved: the name service has not answered yet");
  for (const char* reason : {"unknown", "unknown", "no answer"}) {
    answer("north", fail(reason));
    EXPECT_EQ(names_->unresolved(), std::string{"peer 'north' cannot be resolved: "} + reason);
    after(seconds{3});
  }
  const std::string warning = "warning: peer 'north' cannot be resolved yet: unknown; trying again";
  EXPECT_EQ(told_, Texts{warning});
  answer("north", Addresses{kOne});
  EXPECT_EQ(names_->unresolved(), "");
  after(seconds{0});
  after(seconds{3});
  EXPECT_EQ(told_, (Texts{warning, "peer 'north' has the address 10.0.0.1"}));
}

TEST_F(Names, AreNotReportedIfTheyAreFoundAtOnce) {
  names_->add("peer", "north");
  after(seconds{0});
  answer("north", Addresses{kOne});
  after(seconds{1});
  EXPECT_EQ(told_, Texts{});
}

TEST_F(Names, AreLookedUpAgainWhileNothingComesFromThem) {
  const Ipv4 north = names_->add("peer", "north");
  after(seconds{0});
  after(seconds{30});
  EXPECT_EQ(asked(), Texts{"north"}) << "one look-up at a time";
  answer("north", fail("unknown"));
  after(seconds{3});
  answer("north", Addresses{kOne});
  after(seconds{2});
  EXPECT_EQ(asked(), Texts{});
  after(seconds{1});
  answer("north", Addresses{kTwo});
  EXPECT_EQ(names_->addresses(north), Addresses{kTwo});
  after(seconds{0});
  EXPECT_EQ(told_.back(), "peer 'north' has the address 10.0.0.2");
}

TEST_F(Names, AreLookedUpOnceAMinuteWhileTheirMachinesSend) {
  names_->add("peer", "north");
  after(seconds{0});
  answer("north", Addresses{kOne});
  for (int i = 0; i < 59; ++i) {
    names_->heard(kOne);
    after(seconds{1});
    ASSERT_EQ(asked(), Texts{}) << "after " << i + 1 << " s";
  }
  names_->heard(kOne);
  after(seconds{1});
  EXPECT_EQ(asked(), Texts{"north"});
  answer("north", Addresses{kOne});
  names_->heard(kTwo);  // another machine
  after(seconds{2});
  EXPECT_EQ(asked(), Texts{});
  after(seconds{1});
  EXPECT_EQ(asked(), Texts{"north"}) << "nothing has come for three seconds";
}

TEST_F(Names, KeepTheirAddressesWhileTheNameServiceDoesNotAnswer) {
  const Ipv4 north = names_->add("peer", "north");
  after(seconds{0});
  answer("north", Addresses{kOne});
  after(seconds{3});
  answer("north", fail("no answer"));
  after(seconds{3});
  EXPECT_EQ(names_->addresses(north), Addresses{kOne});
  EXPECT_EQ(names_->unresolved(), "");
  EXPECT_EQ(told_, Texts{});
}

TEST_F(Names, AreNotReportedIfOnlyTheOrderOfTheirAddressesHasChanged) {
  names_->add("peer", "north");
  after(seconds{0});
  answer("north", Addresses{kOne, kTwo});
  after(seconds{3});
  answer("north", Addresses{kTwo, kOne});
  after(seconds{0});
  EXPECT_EQ(told_, Texts{});
}

TEST(HostNames, IgnoreAnAnswerThatComesAfterTheirEnd) {
  os::FoundAddresses late;
  auto names = std::make_shared<HostNames>(
      [&](const std::string&, const os::FoundAddresses& found) { late = found; }, nullptr);
  names->add("peer", "north");
  names->step(Instant{});
  names.reset();
  late(Addresses{kOne});
}

TEST(HostNames, WaitUntilTheirLookUpsHaveEnded) {
  std::vector<std::thread> services;
  const auto names = std::make_shared<HostNames>(
      [&](const std::string&, const os::FoundAddresses& found) {
        services.emplace_back([found] { found(Addresses{kOne}); });
      },
      nullptr);
  const Ipv4 north = names->add("peer", "north");
  names->step(Instant{});
  names->wait(std::chrono::hours{1});
  EXPECT_EQ(names->addresses(north), Addresses{kOne});
  for (std::thread& each : services) each.join();
}

TEST_F(Names, AlsoLeadToTheAddressesThatTheirHostHasAnnounced) {
  const Ipv4 placeholder = names_->add_server("base");
  after(seconds{0});
  answer("base", Addresses{kOne});
  names_->announced(placeholder, {kOne, kTwo});
  EXPECT_EQ(names_->addresses(placeholder), (Addresses{kOne, kTwo}));
  names_->announced(placeholder, {kThree});
  EXPECT_EQ(names_->addresses(placeholder), (Addresses{kOne, kThree}));
  names_->heard(kThree);
  after(seconds{3});
  EXPECT_EQ(asked(), Texts{}) << "the host is alive";
}

TEST_F(Names, ReplaceTheAddressOfADiscoveryServerThatTheyDoNotLookUp) {
  const Ipv4 placeholder = names_->add_server("10.0.0.1");
  EXPECT_TRUE(HostNames::is_placeholder(placeholder));
  after(seconds{0});
  EXPECT_EQ(asked(), Texts{});
  EXPECT_EQ(names_->unresolved(), "");
  EXPECT_EQ(names_->addresses(placeholder), Addresses{kOne});
  names_->announced(placeholder, {kTwo});
  EXPECT_EQ(names_->addresses(placeholder), (Addresses{kOne, kTwo}));
  EXPECT_EQ(told_, Texts{});
}

}  // namespace
}  // namespace takt::dds::host_names_test
