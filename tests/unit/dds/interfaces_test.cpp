#include "interfaces.hpp"

#include <gtest/gtest.h>

namespace takt::dds::interfaces_test {
namespace {

using os::InterfaceAddress;
using os::Ipv4;

constexpr InterfaceAddress kLoopback{
    .interface = 1, .address = {127, 0, 0, 1}, .mask = {255, 0, 0, 0}, .connected = true, .loopback = true};

InterfaceAddress address(int interface, std::uint8_t last, bool connected = true) {
  return {.interface = interface,
          .address = {10, 0, static_cast<std::uint8_t>(interface), last},
          .mask = {255, 255, 255, 0},
          .connected = connected};
}

TEST(Interfaces, AnnounceTheLoopbackAddressIfThereIsNoOther) {
  Interfaces interfaces{{}};
  interfaces.update({kLoopback, address(2, 7, false)});
  EXPECT_EQ(interfaces.announced(), (std::vector<Ipv4>{os::kLoopbackAddress}));
}

TEST(Interfaces, AnnounceAnAddressWhenItsInterfaceIsConnectedAndUntilItIsRemoved) {
  Interfaces interfaces{{}};
  EXPECT_TRUE(interfaces.update({kLoopback, address(2, 7)}).added);
  const std::vector<Ipv4> own{{10, 0, 2, 7}};
  EXPECT_EQ(interfaces.announced(), own);
  EXPECT_FALSE(interfaces.update({kLoopback, address(2, 7, false)}).any) << "a pulled cable is no change";
  EXPECT_EQ(interfaces.announced(), own);
  const Interfaces::Change removed = interfaces.update({kLoopback});
  EXPECT_TRUE(removed.any);
  EXPECT_FALSE(removed.added);
  EXPECT_EQ(interfaces.announced(), (std::vector<Ipv4>{os::kLoopbackAddress}));
}

TEST(Interfaces, NoticeAnInterfaceThatWasCreatedAgainWithTheSameAddress) {
  Interfaces interfaces{{}};
  interfaces.update({kLoopback, address(2, 7)});
  InterfaceAddress again = address(2, 7);
  again.interface = 3;
  EXPECT_TRUE(interfaces.update({kLoopback, again}).added);
}

TEST(Interfaces, TellIfAnAddressIsLostThatOthersUse) {
  Interfaces interfaces{{}};
  interfaces.update({kLoopback, address(2, 7), address(3, 7)});
  interfaces.heard_at({10, 0, 3, 7});
  EXPECT_FALSE(interfaces.update({kLoopback, address(3, 7)}).removed_used);
  EXPECT_TRUE(interfaces.update({kLoopback}).removed_used);
  interfaces.update({kLoopback, address(3, 7)});
  EXPECT_FALSE(interfaces.update({kLoopback}).removed_used) << "nobody has used it since it came back";
}

TEST(Interfaces, TakeALostAddressForTheirOwnUntilAnotherMachineUsesIt) {
  Interfaces interfaces{{}};
  interfaces.update({kLoopback, address(2, 7)});
  interfaces.update({kLoopback, address(2, 8)});
  EXPECT_TRUE(interfaces.comes_from_here({10, 0, 2, 8}));
  EXPECT_TRUE(interfaces.is_mine({10, 0, 2, 7}));
  EXPECT_FALSE(interfaces.comes_from_here({10, 0, 2, 7}));
  EXPECT_FALSE(interfaces.is_mine({10, 0, 2, 7}));
  EXPECT_FALSE(interfaces.is_mine({10, 0, 2, 9}));
}

TEST(Interfaces, UseNewInterfacesForGroupsOnlyAfterTheirAddressesAreAnnounced) {
  Interfaces interfaces{{}};
  interfaces.update({kLoopback});
  interfaces.settle();
  interfaces.update({kLoopback, address(2, 7)});
  EXPECT_EQ(interfaces.for_groups(), Interfaces::List{kLoopback});
  interfaces.settle();
  EXPECT_EQ(interfaces.for_groups(), (Interfaces::List{kLoopback, address(2, 7)}));
}

TEST(Interfaces, UseAnInterfaceWithTwoAddressesOnceForGroups) {
  Interfaces interfaces{{}};
  interfaces.update({kLoopback, address(2, 7), address(2, 8)});
  interfaces.settle();
  EXPECT_EQ(interfaces.for_groups().size(), 2U);
  EXPECT_EQ(interfaces.announced().size(), 2U);
}

TEST(Interfaces, KeepGroupsOnThisMachineIfToldSo) {
  Interfaces interfaces{{.only = {}, .groups_stay_here = true}};
  interfaces.update({kLoopback, address(2, 7)});
  interfaces.settle();
  EXPECT_EQ(interfaces.for_groups(), Interfaces::List{kLoopback});
}

TEST(Interfaces, UseOnlyTheGivenAddressesAndTheLoopbackInterface) {
  Interfaces interfaces{{.only = {{10, 0, 3, 7}}}};
  interfaces.update({kLoopback, address(2, 7), address(3, 7)});
  EXPECT_EQ(interfaces.announced(), (std::vector<Ipv4>{{10, 0, 3, 7}}));
  EXPECT_EQ(interfaces.used(), (Interfaces::List{kLoopback, address(3, 7)}));
  EXPECT_TRUE(interfaces.allows(os::kLoopbackAddress));
  EXPECT_TRUE(interfaces.allows({10, 0, 3, 7}));
  EXPECT_FALSE(interfaces.allows({10, 0, 2, 7}));
  EXPECT_TRUE(interfaces.is_mine({10, 0, 2, 7}))
      << "it belongs to this machine, although it must not be used";
}

TEST(Interfaces, TakeNoPacketThatWasSentToAnAddressThatTheyMustNotUse) {
  Interfaces interfaces{{.only = {{10, 0, 3, 7}}}};
  interfaces.update({kLoopback, address(2, 7), address(3, 7)});
  EXPECT_TRUE(interfaces.receives({10, 0, 3, 7}, 3));
  EXPECT_TRUE(interfaces.receives(os::kLoopbackAddress, 1));
  EXPECT_FALSE(interfaces.receives({10, 0, 2, 7}, 2));
}

TEST(Interfaces, TakeNoMulticastPacketFromAnInterfaceThatIsNotUsedForGroups) {
  Interfaces everywhere{{}};
  Interfaces restricted{{.only = {{10, 0, 3, 7}}}};
  Interfaces here{{.only = {}, .groups_stay_here = true}};
  for (Interfaces* each : {&everywhere, &restricted, &here}) {
    each->update({kLoopback, address(2, 7), address(3, 7)});
    EXPECT_FALSE(each->receives(kGroup, 3)) << "the address is not announced yet";
    each->settle();
    EXPECT_TRUE(each->receives(kGroup, kLoopback.interface));
  }
  EXPECT_TRUE(everywhere.receives(kGroup, 2));
  EXPECT_FALSE(restricted.receives(kGroup, 2));
  EXPECT_TRUE(restricted.receives(kGroup, 3));
  EXPECT_FALSE(here.receives(kGroup, 3));
}

}  // namespace
}  // namespace takt::dds::interfaces_test
