// Tests the DDS participant of a process: its options, its errors, and the side effects that it must not
// have.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>

#include <filesystem>
#include <set>
#include <string>
#include <thread>

#include <takt/wire/takt.h>
#include <takt/dds/gateway.hpp>
#include <takt/dds/participant.hpp>
#include <takt/dds/topics.hpp>

#include "domain.hpp"
#include "peer.hpp"
#include "sample.hpp"

namespace takt::dds_test::participant_test {
namespace {

using testing::HasSubstr;

std::set<std::string> files_of_dds() {
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm")) {
    const std::string name = entry.path().filename();
    if (name.find("fast") != std::string::npos) names.insert(name);
  }
  return names;
}

std::size_t threads() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/task")) ++count;
  return count;
}

TEST(Participant, LeavesNoFilesInSharedMemory) {
  const auto before = files_of_dds();
  {
    Peer one{{"all"}};
    Peer other{{"all"}};
    ASSERT_TRUE(one.prints("ready"));
    ASSERT_TRUE(other.prints("ready"));
    EXPECT_EQ(files_of_dds(), before) << "while two processes exchange samples of 30 kB";
    one.signal(SIGKILL);
  }
  EXPECT_EQ(files_of_dds(), before);
}

TEST(Participant, CannotBeCreatedTwiceInOneProcess) {
  auto first = dds::Participant::create(on_loopback("first"));
  ASSERT_TRUE(first.ok()) << to_text(first.problems());
  const auto second = dds::Participant::create(on_loopback("second"));
  ASSERT_FALSE(second.ok());
  EXPECT_THAT(to_text(second.problems()), HasSubstr("this process has a DDS participant already"));
  *first = nullptr;
  EXPECT_TRUE(dds::Participant::create(on_loopback("third")).ok()) << "the first participant is deleted";
}

TEST(Participant, ReportsADomainThatIsOutOfRange) {
  for (const int domain : {-1, 233}) {
    dds::ParticipantOptions options = on_loopback("p");
    options.domain = domain;
    const auto made = dds::Participant::create(options);
    ASSERT_FALSE(made.ok());
    EXPECT_THAT(to_text(made.problems()), HasSubstr("0 to 232"));
  }
}

TEST(Participant, ReportsAnInterfaceAddressThatThisMachineDoesNotHave) {
  dds::ParticipantOptions options = on_loopback("p");
  options.interfaces = {"127.0.0.1", "203.0.113.7"};
  const auto made = dds::Participant::create(options);
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(to_text(made.problems()), HasSubstr("no interface with the address '203.0.113.7'"));
  EXPECT_THAT(to_text(made.problems()), HasSubstr("127.0.0.1"));
  EXPECT_TRUE(dds::Participant::create(on_loopback("p")).ok()) << "the failed attempt left nothing behind";
}

TEST(Participant, NamesThePeersThatCannotBeResolved) {
  dds::ParticipantOptions options = on_loopback("p");
  options.discovery = {
      .kind = model::Discovery::Kind::peers, .peers = {"localhost", "no.such.host.invalid"}, .server = {}};
  const auto made = dds::Participant::create(options);
  ASSERT_TRUE(made.ok()) << "the name may be known later";
  EXPECT_TRUE(soon([&] { return (*made)->unresolved().find("localhost") == std::string::npos; }));
  EXPECT_THAT((*made)->unresolved(), HasSubstr("peer 'no.such.host.invalid' cannot be resolved: "));
}

TEST(Participant, ReportsAnInvalidPeer) {
  for (const char* peer : {"", "10.0.0.256", "host:7400", "two hosts"}) {
    dds::ParticipantOptions options = on_loopback("p");
    options.discovery = {.kind = model::Discovery::Kind::peers, .peers = {"localhost", peer}, .server = {}};
    const auto made = dds::Participant::create(options);
    ASSERT_FALSE(made.ok()) << peer;
    EXPECT_THAT(to_text(made.problems()), HasSubstr("is not a valid peer"));
  }
}

TEST(Participant, ReportsAnInvalidServerPort) {
  for (const char* server : {"localhost:", "localhost:port", "localhost:70000", "localhost:0"}) {
    dds::ParticipantOptions options = on_loopback("p");
    options.discovery = {.kind = model::Discovery::Kind::server, .peers = {}, .server = server};
    const auto made = dds::Participant::create(options);
    ASSERT_FALSE(made.ok()) << server;
    EXPECT_THAT(to_text(made.problems()), HasSubstr("host:port"));
  }
}

TEST(Participant, CannotBeCreatedOnARealTimeThread) {
  bool real_time = false;
  bool refused = false;
  std::thread{[&] {
    const sched_param priority{.sched_priority = 1};
    real_time = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority) == 0;
    if (!real_time) return;
    const auto made = dds::Participant::create(on_loopback("p"));
    refused = !made.ok() && to_text(made.problems()).find("real-time thread") != std::string::npos;
  }}.join();
  if (!real_time) GTEST_SKIP() << "this system allows no real-time threads";
  EXPECT_TRUE(refused);
}

TEST(Participant, CreatesNoThreadsForWritersAndReaders) {
  auto participant = dds::Participant::create(on_loopback("p"));
  ASSERT_TRUE(participant.ok());
  const std::size_t before = threads();
  auto writer = dds::Writer<LifecycleStatus>::create(*participant);
  auto feed = dds::Feed::create(*participant, flow("threads"));
  auto tap =
      dds::Tap::create(*participant, flow("threads"), [](const std::byte*, std::size_t, std::int64_t) {});
  ASSERT_TRUE(writer.ok() && feed.ok() && tap.ok());
  ASSERT_TRUE(soon([&] { return (*feed)->health().matched == 1; }));
  const auto bytes = bytes_of(1, 0, 60000);
  ASSERT_TRUE((*feed)->write(bytes.data(), bytes.size()));
  ASSERT_TRUE(soon([&] { return (*tap)->health().samples == 1; }));
  EXPECT_EQ(threads(), before);
}

TEST(Participant, DoesNotCallAReaderOnTheWritingThread) {
  auto participant = dds::Participant::create(on_loopback("p"));
  ASSERT_TRUE(participant.ok());
  std::atomic<bool> heard{false};
  std::atomic<bool> in_this_thread{false};
  const auto me = std::this_thread::get_id();
  auto feed = dds::Feed::create(*participant, flow("threads"));
  auto tap =
      dds::Tap::create(*participant, flow("threads"), [&](const std::byte*, std::size_t, std::int64_t) {
        in_this_thread = std::this_thread::get_id() == me;
        heard = true;
      });
  ASSERT_TRUE(feed.ok() && tap.ok());
  ASSERT_TRUE(soon([&] { return (*feed)->health().matched == 1; }));
  const auto bytes = bytes_of(1);
  (*feed)->write(bytes.data(), bytes.size());
  ASSERT_TRUE(soon([&] { return heard.load(); }));
  EXPECT_FALSE(in_this_thread);
}

/// Expects that two peers, each with its own environment variables, find each other.
void expect_match(const std::map<std::string, std::string>& one,
                  const std::map<std::string, std::string>& other) {
  Peer tap{{"tap", "discovery", "reliable", "1"}, one};
  ASSERT_TRUE(tap.prints("ready"));
  Peer feed{{"feed", "discovery", "reliable", "1"}, other};
  ASSERT_TRUE(feed.prints("ready"));
  // DDS does not deliver samples that the peer `feed` wrote before it matched `tap`, so `feed` writes again.
  EXPECT_TRUE(soon([&] {
    feed.write("1");
    return tap.line(std::chrono::milliseconds{100}).has_value();
  }));
}

TEST(Discovery, FindsAPeerByMulticast) { expect_match({}, {}); }

TEST(Discovery, FindsAPeerByItsHostName) {
  expect_match({{"PEER_DISCOVERY", "peers=localhost"}}, {{"PEER_DISCOVERY", "peers=localhost"}});
}

TEST(Discovery, FindsAPeerThroughADiscoveryServer) {
  const std::string place = "127.0.0.1:" + std::to_string(20000 + ::getpid() % 20000);
  Peer server{{"device", "server"}, {{"PEER_DISCOVERY", "serve=" + place}}};
  ASSERT_TRUE(server.prints("ready"));
  expect_match({{"PEER_DISCOVERY", "server=" + place}}, {{"PEER_DISCOVERY", "server=" + place}});
}

TEST(Participant, RejectsATopicWhoseTypeConflictsWithAnotherTopic) {
  auto participant = dds::Participant::create(on_loopback("p"));
  ASSERT_TRUE(participant.ok());
  auto first = dds::Feed::create(*participant, flow("shared"));
  ASSERT_TRUE(first.ok());
  dds::Flow other = flow("shared");
  other.type.name = "test::Other";
  const auto refused = dds::Feed::create(*participant, other);
  ASSERT_FALSE(refused.ok());
  EXPECT_THAT(to_text(refused.problems()), HasSubstr("already has the type 'test::Sample'"));
  dds::Flow longer = flow("another");
  longer.type.fields.back().sequence = 7;
  const auto conflicting = dds::Feed::create(*participant, longer);
  ASSERT_FALSE(conflicting.ok());
  EXPECT_THAT(to_text(conflicting.problems()), HasSubstr("two different types named 'test::Sample'"));
  const auto bytes = bytes_of(1);
  EXPECT_TRUE((*first)->write(bytes.data(), bytes.size()));
  first = dds::Feed::create(*participant, flow("third"));  // this also deletes the topic "shared"
  EXPECT_TRUE(dds::Feed::create(*participant, other).ok());
  first = dds::Feed::create(*participant, other);  // this also deletes the type test::Sample
  EXPECT_TRUE(dds::Feed::create(*participant, longer).ok());
}

TEST(Participant, ShutsDownQuicklyWithAllItsEntities) {
  Peer peer{{"all"}};
  Peer other{{"all"}};
  ASSERT_TRUE(peer.prints("ready"));
  peer.write("end");
  EXPECT_EQ(peer.wait(std::chrono::seconds{5}), 0);
}

}  // namespace
}  // namespace takt::dds_test::participant_test
