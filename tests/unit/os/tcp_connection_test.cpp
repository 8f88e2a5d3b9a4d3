#include <takt/os/tcp_connection.hpp>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <string>
#include <thread>

#include <takt/os/clock.hpp>

namespace takt::os::tcp_connection_test {
namespace {

using namespace std::chrono_literals;
using Received = TcpConnection::Received;

/// A connection to a client in this process. A local stream socket behaves like a TCP socket here.
class Connected : public testing::Test {
 protected:
  Connected() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()), 0);
    server = TcpConnection{Fd{ends[0]}};
    client = TcpConnection{Fd{ends[1]}};
  }
  TcpConnection server{Fd{}};
  TcpConnection client{Fd{}};
  std::string text;
};

TEST_F(Connected, AppendsOnlyBytesThatHaveArrived) {
  EXPECT_EQ(server.receive(text, 10), Received::nothing);
  EXPECT_EQ(text, "");
  EXPECT_TRUE(client.send("abcdef", {}));
  EXPECT_EQ(server.receive(text, 4), Received::bytes);
  EXPECT_EQ(server.receive(text, 4), Received::bytes);
  EXPECT_EQ(text, "abcdef");
}

TEST_F(Connected, ReportsTheEndAfterTheLastBytes) {
  EXPECT_TRUE(client.send("last", {}));
  client.end_sending();
  EXPECT_EQ(server.receive(text, 100), Received::bytes);
  EXPECT_EQ(server.receive(text, 100), Received::end);
  EXPECT_EQ(text, "last");
  EXPECT_TRUE(server.send("answer", {})) << "the client may still read";
  EXPECT_EQ(client.receive(text, 100), Received::bytes);
}

TEST_F(Connected, GivesUpAClientThatDoesNotRead) {
  const std::string large(20'000'000, 'x');
  EXPECT_FALSE(server.send(large, {})) << "a deadline in the past";
  EXPECT_FALSE(server.send(large, now() + 10ms));
}

TEST_F(Connected, SendsAllBytesToASlowClient) {
  std::string large(20'000'000, ' ');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * 31 >> 3);
  std::thread sender{[&] {
    EXPECT_TRUE(server.send(large, now() + 60s));
    server.end_sending();
  }};
  while (client.receive(text, 100'000) != Received::end) std::this_thread::yield();
  EXPECT_TRUE(text == large);
  sender.join();
}

TEST_F(Connected, StopsSendingWhenAnotherThreadShutsItDown) {
  const std::string large(20'000'000, 'x');
  std::thread sender{[&] { EXPECT_FALSE(server.send(large, now() + 600s)); }};
  while (client.receive(text, 1) != Received::bytes) std::this_thread::yield();
  server.shut_down();
  sender.join();
}

}  // namespace
}  // namespace takt::os::tcp_connection_test
