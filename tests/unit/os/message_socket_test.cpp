#include <takt/os/message_socket.hpp>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <cstdint>

#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace takt::os::message_socket_test {
namespace {

class SocketPair : public testing::Test {
 protected:
  SocketPair() {
    auto ends = std::move(MessageSocket::pair().value());
    mine = std::move(ends.first);
    theirs = std::move(ends.second);
  }
  MessageSocket mine;
  MessageSocket theirs;
};

TEST_F(SocketPair, PassesWholeMessagesInOrder) {
  EXPECT_TRUE(mine.send("first"));
  EXPECT_TRUE(mine.send(""));
  EXPECT_TRUE(mine.send(std::string{"\0\n\xff", 3}));
  EXPECT_EQ(theirs.receive(), "first");
  EXPECT_EQ(theirs.receive(), "");
  EXPECT_EQ(theirs.receive(), (std::string{"\0\n\xff", 3}));
  EXPECT_EQ(theirs.receive(), std::nullopt);
  EXPECT_FALSE(theirs.closed());
}

TEST_F(SocketPair, PassesAMessageLargerThanTheKernelsBuffer) {
  std::string large(20'000'000, ' ');
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<char>(i * 31 >> 3);
  std::thread sender{[&] {
    EXPECT_TRUE(mine.send_wait(large));
    EXPECT_TRUE(mine.send_wait("after"));
  }};
  const auto received = theirs.receive_wait();
  EXPECT_TRUE(received == large);
  EXPECT_EQ(theirs.receive_wait(), "after");
  sender.join();
}

TEST_F(SocketPair, NeverBlocksEvenIfBothEndsSend) {
  // One thread sends more than the kernel can buffer, from both ends of the socket pair.
  const std::string large(2'000'000, 'x');
  EXPECT_TRUE(mine.send(large));
  EXPECT_TRUE(theirs.send(large));
  std::optional<std::string> here;
  std::optional<std::string> there;
  while (!here || !there) {
    ASSERT_TRUE(mine.flush());
    ASSERT_TRUE(theirs.flush());
    if (!here) here = mine.receive();
    if (!there) there = theirs.receive();
  }
  EXPECT_TRUE(*here == large && *there == large);
}

TEST_F(SocketPair, DeliversMessagesSentBeforeTheOtherEndClosed) {
  mine.send("last words");
  mine.close();
  EXPECT_EQ(theirs.receive_wait(), "last words");
  EXPECT_FALSE(theirs.closed());
  EXPECT_EQ(theirs.receive_wait(), std::nullopt);
  EXPECT_TRUE(theirs.closed());
  EXPECT_EQ(theirs.receive(), std::nullopt);
}

TEST_F(SocketPair, ReportsThatTheOtherEndIsGone) {
  theirs.close();
  EXPECT_FALSE(mine.send("hello"));
  EXPECT_EQ(mine.receive(), std::nullopt);
  EXPECT_TRUE(mine.closed());
}

TEST_F(SocketPair, DiscardsAnIncompleteMessage) {
  const std::uint32_t length = 100;
  ::send(mine.fd().get(), &length, sizeof length, 0);
  ::send(mine.fd().get(), "half", 4, 0);
  EXPECT_EQ(theirs.receive(), std::nullopt);
  EXPECT_FALSE(theirs.closed());
  mine.close();
  EXPECT_EQ(theirs.receive_wait(), std::nullopt);
  EXPECT_TRUE(theirs.closed());
}

TEST_F(SocketPair, ClosesAfterAMessageWithAnImpossibleLength) {
  const std::uint32_t length = ~0U;
  ::send(mine.fd().get(), &length, sizeof length, 0);
  EXPECT_EQ(theirs.receive_wait(), std::nullopt);
  EXPECT_TRUE(theirs.closed());
}

}  // namespace
}  // namespace takt::os::message_socket_test
