#include <takt/os/network.hpp>

#include <gtest/gtest.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <future>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <long_enough.hpp>
#include <takt/os/signals.hpp>
#include <takt/os/udp_socket.hpp>

namespace takt::os::network_test {
namespace {

constexpr Ipv4 kGroup{239, 255, 7, 7};

/// Turns the loopback interface of this process's network on or off.
void turn_loopback(bool on) {
  const Fd socket{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)};
  ifreq request{};
  std::strcpy(request.ifr_name, "lo");
  request.ifr_flags = on ? IFF_UP | IFF_RUNNING : 0;
  ASSERT_EQ(::ioctl(socket.get(), SIOCSIFFLAGS, &request), 0);
}

/// Runs `test` in a copy of this process that has a network of its own, whose loopback interface is off.
/// Returns what `test` returns; empty if the copy cannot have a network of its own.
template <class Test>
std::optional<std::string> in_own_network(Test test) {
  std::array<int, 2> ends{};
  EXPECT_EQ(::pipe(ends.data()), 0);
  const pid_t copy = ::fork();
  if (copy == 0) {
    std::string said;
    if (::unshare(CLONE_NEWNET) == 0) said = test();
    static_cast<void>(::write(ends[1], said.data(), said.size()));
    ::_exit(0);
  }
  ::close(ends[1]);
  std::array<char, 4096> text{};
  const ssize_t n = ::read(ends[0], text.data(), text.size());
  ::close(ends[0]);
  ::waitpid(copy, nullptr, 0);
  if (n <= 0) return std::nullopt;
  return std::string{text.data(), static_cast<std::size_t>(n)};
}

int loopback_interface() { return static_cast<int>(if_nametoindex("lo")); }

TEST(Addresses, AreWrittenWithDots) {
  EXPECT_EQ(in_dots({10, 0, 0, 7}), "10.0.0.7");
  EXPECT_EQ(in_dots({0, 255, 0, 0}), "0.255.0.0");
}

TEST(Addresses, AreReadFromText) {
  EXPECT_EQ(from_dots("10.0.0.7"), (Ipv4{10, 0, 0, 7}));
  for (const char* other : {"", "10.0.0", "10.0.0.256", "10.0.0.7 ", "localhost"})
    EXPECT_EQ(from_dots(other), std::nullopt) << other;
}

TEST(LookUp, FindsTheAddressesOfAHost) {
  std::promise<Result<std::vector<Ipv4>>> answer;
  look_up("localhost", [&](const auto& found) { answer.set_value(found); });
  const auto found = answer.get_future().get();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->front(), kLoopbackAddress);
}

TEST(LookUp, SaysWhyThereIsNoAddress) {
  std::promise<Result<std::vector<Ipv4>>> answer;
  look_up("a..b", [&](const auto& found) { answer.set_value(found); });
  const auto found = answer.get_future().get();
  ASSERT_FALSE(found);
  EXPECT_FALSE(found.problems().front().what.empty());
}

TEST(InterfaceAddresses, ContainTheLoopbackInterface) {
  const auto all = interface_addresses();
  ASSERT_TRUE(all);
  const auto loopback = std::find_if(all->begin(), all->end(), [](const InterfaceAddress& each) {
    return each.address == kLoopbackAddress;
  });
  ASSERT_NE(loopback, all->end());
  EXPECT_EQ(*loopback, (InterfaceAddress{.interface = loopback_interface(),
                                         .address = kLoopbackAddress,
                                         .mask = {255, 0, 0, 0},
                                         .connected = true,
                                         .loopback = true}));
}

TEST(InterfaceNews, TellThatAnInterfaceHasAppearedAndDisappeared) {
  const auto said = in_own_network([]() -> std::string {
    const auto news = InterfaceNews::open();
    if (!news) return "no news";
    if (news->take()) return "there are news at the beginning";
    for (const bool on : {true, false}) {
      turn_loopback(on);
      if (!wait_readable({&news->fd()}, 10'000) || !news->take()) return "no change was told";
      const auto all = interface_addresses();
      const bool connected =
          all && std::any_of(all->begin(), all->end(), [](const auto& each) { return each.connected; });
      if (connected != on) return "the list of addresses is not up to date";
    }
    return "all was told";
  });
  if (!said) GTEST_SKIP() << "this process cannot have a network of its own";
  EXPECT_EQ(*said, "all was told");
}

class UdpSockets : public ::testing::Test {
 protected:
  /// Opens a socket on a port that is free.
  UdpSocket open_any() {
    for (port_ = 20000; port_ < 21000; ++port_) {
      if (auto socket = UdpSocket::open({.port = port_, .shared = false})) return std::move(*socket);
    }
    throw std::runtime_error{"no port is free"};
  }
  std::uint16_t port_ = 0;
  std::array<std::uint8_t, 64> buffer_{};
  const std::vector<std::uint8_t> hello_{'h', 'e', 'l', 'l', 'o'};
};

TEST_F(UdpSockets, TellWhereAPacketComesFromAndToWhichAddressItWasSent) {
  UdpSocket in = open_any();
  auto out = UdpSocket::open({});
  ASSERT_TRUE(out);
  ASSERT_TRUE(out->send(hello_, {.address = {127, 0, 0, 9}, .port = port_}));
  const auto packet = in.receive(buffer_);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->size, hello_.size());
  EXPECT_TRUE(std::equal(hello_.begin(), hello_.end(), buffer_.begin()));
  EXPECT_EQ(packet->from.address, kLoopbackAddress);
  EXPECT_NE(packet->from.port, 0);
  EXPECT_EQ(packet->to, (Ipv4{127, 0, 0, 9}));
  EXPECT_EQ(packet->interface, loopback_interface());
}

TEST_F(UdpSockets, SendFromTheChosenAddress) {
  UdpSocket in = open_any();
  auto out = UdpSocket::open({});
  ASSERT_TRUE(out);
  const InterfaceAddress from{.interface = loopback_interface(), .address = {127, 0, 0, 5}};
  ASSERT_TRUE(out->send(hello_, {.address = kLoopbackAddress, .port = port_}, &from));
  const auto packet = in.receive(buffer_);
  ASSERT_TRUE(packet);
  EXPECT_EQ(packet->from.address, from.address);
}

TEST_F(UdpSockets, ReceiveAGroupOnlyWhileTheyHaveJoinedIt) {
  UdpSocket in = open_any();
  auto out = UdpSocket::open({});
  ASSERT_TRUE(out);
  const InterfaceAddress here{.interface = loopback_interface(), .address = kLoopbackAddress};
  const auto hears_the_group = [&] {
    // The second packet always arrives, so the first one has arrived, too, if the socket receives the group.
    EXPECT_TRUE(out->send(hello_, {.address = kGroup, .port = port_}, &here));
    EXPECT_TRUE(out->send(hello_, {.address = kLoopbackAddress, .port = port_}));
    const auto first = in.receive(buffer_);
    if (!first || first->to != kGroup) return false;
    EXPECT_EQ(in.receive(buffer_)->to, kLoopbackAddress);
    return true;
  };
  EXPECT_FALSE(hears_the_group());
  EXPECT_TRUE(in.join(kGroup, here.interface));
  EXPECT_TRUE(in.join(kGroup, here.interface)) << "it has joined the group already";
  EXPECT_TRUE(hears_the_group());
  in.leave(kGroup, here.interface);
  EXPECT_FALSE(hears_the_group());
  EXPECT_FALSE(in.join(kGroup, 1 << 30)) << "there is no such interface";
}

TEST_F(UdpSockets, ReportAPortThatIsInUse) {
  const UdpSocket in = open_any();
  const auto second = UdpSocket::open({.port = port_});
  ASSERT_FALSE(second);
  EXPECT_NE(second.problems().front().what.find("UDP port " + std::to_string(port_)), std::string::npos);
}

TEST_F(UdpSockets, ReturnNothingAfterTheyWereStopped) {
  UdpSocket in = open_any();
  auto waiting = std::async(std::launch::async, [&] { return in.receive(buffer_).has_value(); });
  in.stop();
  ASSERT_EQ(waiting.wait_for(long_enough()), std::future_status::ready);
  EXPECT_FALSE(waiting.get());
  EXPECT_FALSE(in.receive(buffer_));
}

}  // namespace
}  // namespace takt::os::network_test
