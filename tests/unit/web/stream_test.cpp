#include "web/stream.hpp"

#include <atomic>
#include <set>
#include <thread>

#include <gmock/gmock.h>

#include "web/server.hpp"

namespace takt::tool::web::stream_test {
namespace {

using namespace std::chrono_literals;

TEST(Stream, ReturnsEachEventOnceAndInOrder) {
  std::atomic<std::size_t> all{0};
  Stream stream{"a", all};
  EXPECT_EQ(stream.next(0ms), "") << "nothing was sent";
  stream.send("1");
  stream.send("2");
  EXPECT_EQ(stream.next(0ms), "12");
  EXPECT_EQ(stream.next(0ms), "");
}

TEST(Stream, WakesAWaitingReaderWhenAnEventIsSent) {
  std::atomic<std::size_t> all{0};
  Stream stream{"a", all};
  std::thread sender{[&stream] { stream.send("now"); }};
  EXPECT_EQ(stream.next(60s), "now");
  sender.join();
  std::thread ender{[&stream] { stream.end(); }};
  EXPECT_EQ(stream.next(60s), std::nullopt);
  ender.join();
}

TEST(Stream, EndsIfTheReaderIsTooSlow) {
  std::atomic<std::size_t> all{0};
  Stream stream{"a", all};
  const std::string part(Stream::kMostBytes / 4, 'x');
  for (int i = 0; i < 4; ++i) stream.send(part);
  EXPECT_FALSE(stream.ended());
  stream.send("y");
  EXPECT_TRUE(stream.ended());
  EXPECT_EQ(stream.next(0ms), std::nullopt)
      << "after a gap the browser must reconnect and get the complete state";
}

TEST(Stream, CountsTheEventsThatAreBeingSent) {
  std::atomic<std::size_t> all{0};
  {
    Stream stream{"a", all};
    stream.send(std::string(Stream::kMostBytes - 1, 'x'));
    EXPECT_EQ(stream.next(0ms)->size(), Stream::kMostBytes - 1);
    stream.send("1");
    EXPECT_EQ(all, Stream::kMostBytes);
    EXPECT_EQ(stream.next(0ms), "1");
    EXPECT_EQ(all, 1U) << "the first events have been sent";
    stream.send(std::string(Stream::kMostBytes, 'x'));
    EXPECT_TRUE(stream.ended());
    EXPECT_EQ(all, 1U);
  }
  EXPECT_EQ(all, 0U);
}

TEST(Streams, OfFastBrowsersContinueWhenSlowBrowsersFillTheMemoryLimit) {
  Streams streams;
  std::vector<std::shared_ptr<Stream>> slow;
  for (std::size_t i = 0; i < Streams::kMost / 2; ++i) slow.push_back(streams.open("slow"));
  const auto fast = streams.open("fast");
  const std::string text(std::size_t{100} << 10, 'x');
  std::size_t sent = 0;
  for (; sent < Stream::kMostBytes / 2; sent += text.size()) {
    streams.send(text);
    EXPECT_EQ(fast->next(0ms), text);
  }
  EXPECT_GT(streams.count(), 1U);
  EXPECT_LE((streams.count() - 1) * sent, Stream::kMostOfAll);
}

TEST(Streams, AllReceiveTheSameEventsUntilTheyAreClosed) {
  Streams streams;
  const auto one = streams.open("a");
  const auto other = streams.open("a");
  streams.send("a");
  streams.close(one);
  streams.send("b");
  EXPECT_EQ(one->next(0ms), std::nullopt);
  EXPECT_EQ(other->next(0ms), "ab");
  EXPECT_EQ(streams.find(other->id()), other);
  EXPECT_EQ(streams.find(one->id()), nullptr);
  EXPECT_EQ(streams.count(), 1U);
}

TEST(Streams, OfOneAddressLeavePlacesForOtherAddresses) {
  Streams streams;
  std::vector<std::shared_ptr<Stream>> open;
  while (auto stream = streams.open("10.0.0.1")) open.push_back(std::move(stream));
  EXPECT_EQ(open.size(), Streams::kMost / 2);
  std::size_t other = 0;
  for (; auto stream = streams.open("10.0.0.2"); ++other) open.push_back(std::move(stream));
  EXPECT_EQ(other, Streams::kMost / 4);
  EXPECT_TRUE(streams.open("10.0.0.3"));
}

TEST(Streams, AreLimitedInNumber) {
  Streams streams;
  std::vector<std::shared_ptr<Stream>> open;
  std::set<std::string> ids;
  for (std::size_t i = 0; i < Streams::kMost; ++i) {
    open.push_back(streams.open(std::to_string(i)));
    ASSERT_TRUE(open.back());
    ids.insert(open.back()->id());
  }
  EXPECT_EQ(ids.size(), Streams::kMost);
  EXPECT_FALSE(streams.open("new"));
  open.front()->end();
  EXPECT_FALSE(streams.open("new")) << "a thread may still send the last events of the stream";
  streams.close(open.front());
  EXPECT_TRUE(streams.open("new"));
  streams.end();
  EXPECT_TRUE(open.back()->ended());
  EXPECT_FALSE(streams.open("newer"));
}

TEST(EventText, HasTheFormatOfServerSentEvents) {
  EXPECT_EQ(event_text("state", "{}"), "event: state\ndata: {}\n\n");
}

TEST(RandomWord, DiffersEachTime) {
  EXPECT_EQ(random_word(16).size(), 32U);
  EXPECT_NE(random_word(16), random_word(16));
}

TEST(OwnName, MustBeAnIpAddressLocalhostTheMachineNameOrAnAllowedName) {
  for (const char* own : {"127.0.0.1:8080", "10.0.0.7", "localhost", "LOCALHOST:80", "[::1]:8080", "[::1]",
                          "Pc7:8080", "pc7", "cells.EXAMPLE:443"})
    EXPECT_TRUE(is_own_name(own, {"pc7", "Cells.example"})) << own;
  for (const char* other : {"", ":80", "evil.example", "evil.example:8080", "pc7.evil.example",
                            "127.0.0.1.evil.example", "localhost.evil", "example"})
    EXPECT_FALSE(is_own_name(other, {"pc7", "cells.example"})) << other;
}

}  // namespace
}  // namespace takt::tool::web::stream_test
