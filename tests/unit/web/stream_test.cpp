#include "web/stream.hpp"

#include <set>
#include <thread>

#include <gmock/gmock.h>

#include "web/server.hpp"

namespace takt::tool::web::stream_test {
namespace {

using namespace std::chrono_literals;

TEST(Stream, ReturnsEachEventOnceAndInOrder) {
  Stream stream{"a"};
  EXPECT_EQ(stream.next(0ms), "") << "nothing was sent";
  stream.send("1");
  stream.send("2");
  EXPECT_EQ(stream.next(0ms), "12");
  EXPECT_EQ(stream.next(0ms), "");
}

TEST(Stream, WakesAWaitingReaderWhenAnEventIsSent) {
  Stream stream{"a"};
  std::thread sender{[&stream] { stream.send("now"); }};
  EXPECT_EQ(stream.next(60s), "now");
  sender.join();
  std::thread ender{[&stream] { stream.end(); }};
  EXPECT_EQ(stream.next(60s), std::nullopt);
  ender.join();
}

TEST(Stream, EndsIfTheReaderIsTooSlow) {
  Stream stream{"a"};
  const std::string part(Stream::kMostBytes / 4, 'x');
  for (int i = 0; i < 4; ++i) stream.send(part);
  EXPECT_FALSE(stream.ended());
  stream.send("y");
  EXPECT_TRUE(stream.ended());
  EXPECT_EQ(stream.next(0ms), std::nullopt)
      << "after a gap the browser must reconnect and get the complete state";
}

TEST(Streams, AllReceiveTheSameEventsUntilTheyAreClosed) {
  Streams streams;
  const auto one = streams.open();
  const auto other = streams.open();
  streams.send("a");
  streams.close(one);
  streams.send("b");
  EXPECT_EQ(one->next(0ms), std::nullopt);
  EXPECT_EQ(other->next(0ms), "ab");
  EXPECT_EQ(streams.find(other->id()), other);
  EXPECT_EQ(streams.find(one->id()), nullptr);
  EXPECT_EQ(streams.count(), 1U);
}

TEST(Streams, AreLimitedInNumber) {
  Streams streams;
  std::vector<std::shared_ptr<Stream>> open;
  std::set<std::string> ids;
  for (std::size_t i = 0; i < Streams::kMost; ++i) {
    open.push_back(streams.open());
    ASSERT_TRUE(open.back());
    ids.insert(open.back()->id());
  }
  EXPECT_EQ(ids.size(), Streams::kMost);
  EXPECT_FALSE(streams.open());
  open.front()->end();
  EXPECT_TRUE(streams.open()) << "a stream that has ended does not count";
  streams.end();
  EXPECT_TRUE(open.back()->ended());
  EXPECT_FALSE(streams.open());
}

TEST(EventText, HasTheFormatOfServerSentEvents) {
  EXPECT_EQ(event_text("state", "{}"), "event: state\ndata: {}\n\n");
}

TEST(RandomWord, DiffersEachTime) {
  EXPECT_EQ(random_word(16).size(), 32U);
  EXPECT_NE(random_word(16), random_word(16));
}

TEST(OwnName, MustBeAnIpAddressLocalhostOrTheMachineName) {
  for (const char* own :
       {"127.0.0.1:8080", "10.0.0.7", "localhost", "LOCALHOST:80", "[::1]:8080", "[::1]", "Pc7:8080", "pc7"})
    EXPECT_TRUE(is_own_name(own, "pc7")) << own;
  for (const char* other : {"", ":80", "evil.example", "evil.example:8080", "pc7.evil.example",
                            "127.0.0.1.evil.example", "localhost.evil"})
    EXPECT_FALSE(is_own_name(other, "pc7")) << other;
}

}  // namespace
}  // namespace takt::tool::web::stream_test
