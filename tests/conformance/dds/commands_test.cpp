// Tests commands and replies that processes exchange over DDS.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include <takt/wire/taktPubSubTypes.h>
#include <takt/dds/commands.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/model/type.hpp>
#include "inside.hpp"

#include "domain.hpp"
#include "peer.hpp"

namespace takt::dds_test::commands_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

std::shared_ptr<dds::Participant> participate() {
  auto made = dds::Participant::create(on_loopback("test"));
  EXPECT_TRUE(made.ok()) << to_text(made.problems());
  return made.ok() ? *made : nullptr;
}

std::int64_t wall_ns() {
  return std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

class TestClient {
 public:
  explicit TestClient(const std::shared_ptr<dds::Participant>& participant)
      : client_(std::move(*dds::CommandClient::create(participant, [this](const wire::WholeReply& reply) {
          const std::lock_guard lock{mutex_};
          replies_.push_back(reply);
          came_.notify_all();
        }))) {}

  bool send(const std::string& id, const std::string& data = {}, Nanoseconds time = 20s,
            const std::string& device = "d") {
    wire::WholeCommand command{.head = {}, .data = data};
    command.head.id(id);
    command.head.device(device);
    command.head.kind(COMMAND_REPORT);
    command.head.deadline_ns(wall_ns() + time.count());
    return client_.send(command);
  }
  bool is_too_late(const std::string& id) { return client_.is_too_late(id); }
  std::optional<wire::WholeReply> next(std::chrono::milliseconds limit = long_enough()) {
    std::unique_lock lock{mutex_};
    if (!came_.wait_for(lock, limit, [this] { return !replies_.empty(); })) return std::nullopt;
    auto reply = std::move(replies_.front());
    replies_.pop_front();
    return reply;
  }

 private:
  std::mutex mutex_;
  std::condition_variable came_;
  std::deque<wire::WholeReply> replies_;
  dds::CommandClient client_;
};

TEST(Commands, FromTwoHundredNewClientsAreAllAnswered) {
  Peer server{{"server", "d", "10"}};
  ASSERT_TRUE(server.prints("ready"));
  std::atomic<int> next{0};
  std::atomic<int> answered{0};
  std::mutex mutex;
  std::vector<int> times;
  std::vector<std::thread> clients;
  for (int i = 0; i < 4; ++i) {
    clients.emplace_back([&] {
      for (int number = next++; number < 200; number = next++) {
        Peer client{{"client", "d", "once" + std::to_string(number), "0"}};
        const auto line = client.line();
        if (client.wait() == 0) ++answered;
        const std::lock_guard lock{mutex};
        if (line) times.push_back(std::stoi(line->substr(line->rfind(' '))));
      }
    });
  }
  for (std::thread& each : clients) each.join();
  EXPECT_EQ(answered, 200);
  std::sort(times.begin(), times.end());
  ASSERT_EQ(times.size(), 200U);
  std::cout << "answered after " << times[100] << " ms, at most " << times.back() << " ms\n";
}

/// Builds a message type with the layout of those in idl/takt.idl: first a text field for each name in
/// `before`, then the fields `between`, and last a text field for each name and maximum length in `after`.
model::Type wire_type(const std::string& name, const std::vector<std::string>& before,
                      std::vector<model::Field> between,
                      const std::vector<std::pair<std::string, std::size_t>>& after) {
  model::Type type{.name = name, .fields = {}};
  for (const std::string& text : before)
    type.fields.push_back({.name = text, .scalar = model::Scalar::text, .bound = 63});
  for (model::Field& field : between) type.fields.push_back(std::move(field));
  for (const auto& [text, bound] : after)
    type.fields.push_back({.name = text, .scalar = model::Scalar::text, .bound = bound});
  return type;
}
model::Field enumeration(const std::string& name, std::vector<std::string> enumerators) {
  return {.name = name, .scalar = model::Scalar::enumeration, .enumerators = std::move(enumerators)};
}
void add_parts(model::Type& type) {
  type.fields.push_back({.name = "part", .scalar = model::Scalar::uint32});
  type.fields.push_back({.name = "parts", .scalar = model::Scalar::uint32});
  type.fields.push_back({.name = "data", .scalar = model::Scalar::octet, .sequence = 1024});
}

model::Type command_type() {
  model::Type command = wire_type("takt::Command", {"id", "device", "node", "module_name"},
                                  {enumeration("kind", {"COMMAND_REPORT"})},
                                  {{"deployment", 63}, {"property", 63}, {"value", 255}});
  command.fields.push_back({.name = "time_ns", .scalar = model::Scalar::int64});
  command.fields.push_back({.name = "deadline_ns", .scalar = model::Scalar::int64});
  add_parts(command);
  return command;
}

model::Type reply_type() {
  model::Type reply =
      wire_type("takt::Reply", {"id", "device", "node", "module_name"},
                {enumeration("code", {"OK", "REFUSED", "FAILED", "LATE"}),
                 enumeration("state", {"IDLE", "INITIALIZE", "START", "EXECUTING", "RECOVER", "DESTRUCT"})},
                {{"text", 255}, {"value", 255}});
  add_parts(reply);
  return reply;
}

constexpr dds::Quality kReliable{.reliable = true, .depth = 32, .deadline = {}, .lifespan = {}};

/// Records the last reply to any client, as JSON.
class Replies {
 public:
  explicit Replies(const std::shared_ptr<dds::Participant>& participant) {
    auto made = dds::Tap::create(participant, {.topic = "takt/reply", .type = type_, .quality = kReliable},
                                 [this](const std::byte* data, std::size_t size, std::int64_t) {
                                   const std::lock_guard lock{mutex_};
                                   last_ = model::sample_json(type_, data, size);
                                 });
    EXPECT_TRUE(made.ok());
    if (made.ok()) tap_ = std::move(*made);
  }

  std::string last() const {
    const std::lock_guard lock{mutex_};
    return last_;
  }

 private:
  const model::Type type_ = reply_type();
  mutable std::mutex mutex_;
  std::string last_;
  std::unique_ptr<dds::Tap> tap_;
};

TEST(Commands, AreAnsweredOnlyAfterTheReplyReaderHasMatched) {
  const model::Type command = command_type();
  Peer server{{"server", "d", "0"}};
  ASSERT_TRUE(server.prints("ready"));
  auto participant = participate();
  auto writer =
      dds::Feed::create(participant, {.topic = "takt/command", .type = command, .quality = kReliable});
  ASSERT_TRUE(writer.ok());
  ASSERT_TRUE(soon([&] { return (*writer)->health().matched == 1; }));
  std::this_thread::sleep_for(300ms);  // time for the server's reader to match this writer
  const auto bytes = model::sample_bytes(command, R"({"id": "raw", "device": "d", "parts": 1})");
  ASSERT_TRUE(bytes.ok());
  ASSERT_TRUE((*writer)->write(bytes->data(), bytes->size()));
  ASSERT_TRUE(server.prints("handled raw 0"));
  std::this_thread::sleep_for(500ms);  // a server that ignored the missing reader would reply now
  Replies replies{participant};
  EXPECT_TRUE(soon([&] { return replies.last().find("for raw") != std::string::npos; })) << replies.last();
}

TEST(Commands, WithDamagedDataAreRejected) {
  const model::Type command = command_type();
  Peer server{{"server", "d", "0"}};
  ASSERT_TRUE(server.prints("ready"));
  auto participant = participate();
  Replies replies{participant};
  auto writer =
      dds::Feed::create(participant, {.topic = "takt/command", .type = command, .quality = kReliable});
  ASSERT_TRUE(writer.ok());
  const auto bytes =
      model::sample_bytes(command, R"({"id": "raw", "device": "d", "parts": 1, "data": [120, 1]})");
  ASSERT_TRUE(bytes.ok());
  EXPECT_TRUE(soon([&] {
    if ((*writer)->write(bytes->data(), bytes->size())) std::this_thread::sleep_for(10ms);
    return replies.last().find("the data of the command are damaged") != std::string::npos;
  })) << replies.last();
  server.write("refused");
  EXPECT_TRUE(server.prints("refused 1"));
}

TEST(Commands, CanCarrySixteenMebibytesInBothDirections) {
  const std::size_t most = wire::kMaxData;
  Peer server{{"server", "d", std::to_string(most)}};
  ASSERT_TRUE(server.prints("ready"));
  TestClient client{participate()};
  const auto begin = Clock::now();
  std::mt19937 random{1};  // such data cannot be compressed
  std::string data(most, '\0');
  for (char& each : data) each = static_cast<char>(random());
  ASSERT_TRUE(client.send("long", data, 60s));
  const auto reply = client.next();
  ASSERT_TRUE(reply.has_value());
  std::cout << "round trip in " << std::chrono::duration<double>(Clock::now() - begin).count() << " s\n";
  EXPECT_EQ(reply->data, std::string(most, 'r'));
  EXPECT_EQ(server.line(), "handled long " + std::to_string(most));
  EXPECT_FALSE(client.send("longer", std::string(most + 1, 'x')));
}

TEST(Commands, WithTheSameIdAreExecutedOnlyOnce) {
  Peer server{{"server", "d", "3"}};
  ASSERT_TRUE(server.prints("ready"));
  TestClient client{participate()};
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(client.send("same"));
    const auto reply = client.next();
    ASSERT_TRUE(reply.has_value());
    EXPECT_EQ(reply->head.value().to_string(), "for same");
    EXPECT_EQ(reply->head.device().to_string(), "d");
    EXPECT_EQ(reply->head.node().to_string(), "node");
  }
  ASSERT_TRUE(client.send("end"));
  ASSERT_TRUE(client.next().has_value());
  EXPECT_EQ(server.line(), "handled same 0");
  EXPECT_EQ(server.line(), "handled end 0");
}

TEST(Commands, ReachAServerThatStartsLater) {
  TestClient client{participate()};
  client.send("early");
  Peer other{{"server", "other", "0"}};
  ASSERT_TRUE(other.prints("ready"));
  std::this_thread::sleep_for(300ms);
  Peer server{{"server", "d", "0"}};
  EXPECT_TRUE(client.next().has_value());
  EXPECT_TRUE(server.prints("handled early 0"));
}

TEST(Commands, AreNotSentAfterTheirDeadline) {
  TestClient client{participate()};
  client.send("late", {}, 200ms);
  EXPECT_FALSE(client.is_too_late("late"));
  std::this_thread::sleep_for(300ms);
  EXPECT_TRUE(client.is_too_late("late"));
  Peer server{{"server", "d", "0"}};
  ASSERT_TRUE(server.prints("ready"));
  client.send("punctual");
  ASSERT_TRUE(client.next().has_value());
  EXPECT_EQ(server.line(), "handled punctual 0");
}

TEST(Commands, ThatStartBeforeTheirDeadlineMayFinishAfterIt) {
  Peer server{{"server", "d", "3", "1500"}};
  ASSERT_TRUE(server.prints("ready"));
  TestClient client{participate()};
  client.send("slow", {}, 500ms);
  ASSERT_TRUE(server.prints("handled slow 0"));
  std::this_thread::sleep_for(600ms);
  EXPECT_FALSE(client.is_too_late("slow"));
  const auto reply = client.next();
  ASSERT_TRUE(reply.has_value()) << "a command must only begin before its deadline";
  EXPECT_EQ(reply->head.value().to_string(), "for slow");
  client.send("end");
  ASSERT_TRUE(client.next().has_value());
  EXPECT_EQ(server.line(), "handled end 0") << "the slow command was handled once";
}

TEST(Commands, OfAStoppedClientDoNotDelayOtherClients) {
  Peer server{{"server", "d", "2000000"}};
  ASSERT_TRUE(server.prints("ready"));
  TestClient client{participate()};
  client.send("first");
  ASSERT_TRUE(client.next().has_value());
  Peer stuck{{"client", "d", "stuck", "4000000"}};
  ASSERT_TRUE(server.prints("handled first 0"));
  ASSERT_TRUE(server.prints("handled stuck 4000000"));
  stuck.signal(SIGSTOP);
  const auto begin = Clock::now();
  client.send("second");
  ASSERT_TRUE(client.next().has_value());
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  std::cout << "answered after " << seconds << " s\n";
  EXPECT_LT(seconds, 10.0) << "the stuck client's lease is 3 s";
}

TEST(Commands, AboveTheRateLimitDoNotBlockOtherClients) {
  Peer server{{"server", "d", "0"}};
  ASSERT_TRUE(server.prints("ready"));
  const auto participant = participate();
  TestClient flood{participant};
  for (int i = 0; i < 5000; ++i) flood.send("flood " + std::to_string(i));
  Peer other{{"client", "d", "other", "0"}};
  EXPECT_EQ(other.wait(), 0) << "the other client's command must be answered";
  bool said = false;
  bool counted = false;
  // On a busy machine, newer commands of a flood overwrite most older ones before they reach the server. So
  // the test repeats the flood.
  for (int again = 0; again < 20 && !counted; ++again) {
    server.write("refused");
    while (const auto line = server.line(5s)) {
      said |= line->find("rejected a command: more than 100 commands per second from one client") !=
              std::string::npos;
      if (!line->starts_with("refused ")) continue;
      counted = std::stoul(line->substr(8)) > 1000;
      break;
    }
    for (int i = 0; i < 2000 && !counted; ++i)
      flood.send("more " + std::to_string(again) + " " + std::to_string(i));
  }
  EXPECT_TRUE(said);
  EXPECT_TRUE(counted);
}

TEST(Commands, ThatAreForgedDoNotBlockValidCommands) {
  Peer server{{"server", "d", "0"}};
  ASSERT_TRUE(server.prints("ready"));
  Command good;
  good.id("forged");
  good.device("d");
  good.kind(COMMAND_STOP);
  good.parts(2);  // the second part is never sent, so no forged command becomes complete
  good.data(std::vector<std::uint8_t>(100, 7));
  Peer forger{{"forge", "takt/command", "takt::Command", "plain", "3000", in_hex<CommandPubSubType>(good)}};
  ASSERT_TRUE(forger.prints("forged"));
  TestClient client{participate()};
  client.send("honest");
  EXPECT_TRUE(client.next().has_value());
  ASSERT_TRUE(server.prints("handled honest 0"));
  server.write("refused");
  auto line = server.line();
  while (line && line->starts_with("notice ")) line = server.line();
  ASSERT_TRUE(line.has_value());
  std::cout << *line << " of 3000\n";
  EXPECT_GT(std::stoul(line->substr(line->find(' '))), 1000U);
}

}  // namespace
}  // namespace takt::dds_test::commands_test
