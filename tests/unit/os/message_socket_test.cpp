#include <takt/os/message_socket.hpp>

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
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

TEST_F(SocketPair, PassesEachFileWithItsMessageEvenIfTheKernelsBufferIsFull) {
  const auto pipe_of = [](std::array<int, 2> ends) {
    EXPECT_EQ(::pipe(ends.data()), 0);
    return std::pair{std::make_shared<const Fd>(ends[0]), Fd{ends[1]}};
  };
  const auto first = pipe_of({});
  const auto second = pipe_of({});
  ASSERT_EQ(::write(first.second.get(), "1", 1), 1);
  ASSERT_EQ(::write(second.second.get(), "2", 1), 1);
  theirs.accept_files();
  const std::string large(1'000'000, 'x');
  mine.send("without");
  mine.send(large, first.first);
  mine.send("another", second.first);
  mine.send("last");
  std::vector<std::pair<std::size_t, std::string>> received;
  while (received.size() < 4) {
    ASSERT_TRUE(mine.flush());
    const auto message = theirs.receive();
    if (!message) continue;
    const Fd file = theirs.take_file();
    std::string content(1, '-');
    if (file) {
      EXPECT_EQ(::read(file.get(), content.data(), 1), 1);
    }
    received.emplace_back(message->size(), content);
  }
  EXPECT_EQ(received, (std::vector<std::pair<std::size_t, std::string>>{
                          {7, "-"}, {large.size(), "1"}, {7, "2"}, {4, "-"}}));
}

TEST_F(SocketPair, AcceptsFilesOnlyOnRequest) {
  const std::size_t before = open_descriptors().size();
  mine.send("with a file", std::make_shared<const Fd>(::dup(0)));
  EXPECT_EQ(theirs.receive(), "with a file");
  EXPECT_FALSE(theirs.take_file());
  EXPECT_EQ(open_descriptors().size(), before);
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
