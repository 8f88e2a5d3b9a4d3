// Tests DDS Security between processes: a member of a cell receives samples from other members, and none from
// participants outside the cell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <set>
#include <string>

#include <takt/wire/takt.h>
#include <takt/dds/commands.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/dds/topics.hpp>
#include <takt/os/clock.hpp>
#include <takt/security/authority.hpp>

#include "domain.hpp"
#include "peer.hpp"
#include "sample.hpp"

namespace takt::dds_test::security_test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using security::Role;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr auto kLongEnough = 4s;  // a sample would arrive within this time if its sender were not rejected

std::int64_t now_s() { return os::wall_ns() / 1'000'000'000; }

/// A cell "test" with two devices: robot writes the topic "parts", and line reads this topic. anna is an
/// operator, and eve is an observer.
class Security : public testing::Test {
 protected:
  Security() {
    fs::remove_all(folder_);
    plan_.cell.name = "test";
    plan_.domain = domain();
    for (const char* name : {"robot", "line"}) {
      plan_.cell.devices.emplace_back();
      plan_.cell.devices.back().name = name;
    }
    model::Connection connection;
    connection.from = {"robot", "m", "out"};
    connection.to = {"line", "m", "in"};
    connection.topic = "parts";
    plan_.cell.connections = {connection};
    make("home");
  }
  ~Security() override { fs::remove_all(folder_); }

  void make(const std::string& authority) {
    auto made = security::Authority::create((folder_ / authority).string(), "test", now_s());
    ASSERT_TRUE(made.ok());
    for (const auto& [role, name] : {std::pair{Role::device, "robot"},
                                     {Role::device, "line"},
                                     {Role::operator_, "anna"},
                                     {Role::observer, "eve"}}) {
      ASSERT_TRUE(made->issue({"test", role, name}, plan_, 100, now_s()).ok());
    }
  }
  [[nodiscard]] std::string of(const std::string& path, const std::string& authority = "home") const {
    return (folder_ / authority / path).string();
  }
  /// Returns the environment variables that give a peer the identity in the folder `path`.
  [[nodiscard]] std::map<std::string, std::string> as(const std::string& path,
                                                      const std::string& authority = "home") const {
    return {{"PEER_SECURITY", of(path, authority)}};
  }

  /// Makes this process a DDS participant with the identity in the folder `path`.
  void join(const std::string& path) {
    dds::ParticipantOptions options = on_loopback("test");
    options.security = of(path);
    options.refused = [this](const std::string& text) {
      const std::lock_guard lock{mutex_};
      refused_.push_back(text);
    };
    auto made = dds::Participant::create(options);
    ASSERT_TRUE(made.ok()) << to_text(made.problems());
    participant_ = std::move(*made);
    auto reader = dds::Reader<DeviceStatus>::create(
        participant_, {.sample = [this](const DeviceStatus& status, wire::WriterId) {
          const std::lock_guard lock{mutex_};
          heard_.insert(status.device().to_string());
        }});
    ASSERT_TRUE(reader.ok()) << to_text(reader.problems());
    reader_.emplace(std::move(*reader));
  }
  std::set<std::string> heard() {
    const std::lock_guard lock{mutex_};
    return heard_;
  }
  std::vector<std::string> refused() {
    const std::lock_guard lock{mutex_};
    return refused_;
  }
  [[nodiscard]] bool reports(const std::string& text) {
    return soon([&] {
      for (const std::string& each : refused()) {
        if (each.find(text) != std::string::npos) return true;
      }
      return false;
    });
  }

  fs::path folder_ = fs::path{testing::TempDir()} / "takt-dds-security";
  security::Plan plan_;
  std::mutex mutex_;
  std::set<std::string> heard_;
  std::vector<std::string> refused_;
  std::shared_ptr<dds::Participant> participant_;
  std::optional<dds::Reader<DeviceStatus>> reader_;
};

TEST_F(Security, FindsAHaltedMemberAgainWhenItContinues) {
  join("devices/line");
  Peer robot{{"device", "robot"}, as("devices/robot")};
  ASSERT_TRUE(soon([&] { return reader_->matched() == 1; }));
  robot.signal(SIGSTOP);
  ASSERT_TRUE(soon([&] { return reader_->matched() == 0; })) << "the lease is 3 s";
  robot.signal(SIGCONT);
  EXPECT_TRUE(soon([&] { return reader_->matched() == 1; })) << testing::PrintToString(refused());
}

TEST_F(Security, LetsMembersOfOneCellExchangeSamples) {
  join("operators/anna");
  Peer robot{{"device", "robot"}, as("devices/robot")};
  EXPECT_TRUE(soon([&] { return heard().count("robot") > 0; }));
  EXPECT_THAT(refused(), IsEmpty());
}

TEST_F(Security, RejectsAndReportsAParticipantWithoutAnIdentity) {
  join("devices/line");
  Peer plain{{"device", "robot"}};
  ASSERT_TRUE(plain.prints("ready"));
  EXPECT_TRUE(reports("participant 'peer' at 127.0.0.1 has no identity of this cell"));
  std::this_thread::sleep_for(kLongEnough);
  EXPECT_THAT(heard(), IsEmpty());
}

TEST_F(Security, RejectsAndReportsAnIdentityFromAnotherAuthority) {
  make("evil");
  join("devices/line");
  Peer evil{{"device", "robot"}, as("devices/robot", "evil")};
  ASSERT_TRUE(evil.prints("ready"));
  EXPECT_TRUE(reports("device robot at 127.0.0.1: its identity was issued by another authority"));
  std::this_thread::sleep_for(kLongEnough);
  EXPECT_THAT(heard(), IsEmpty());
}

TEST_F(Security, RejectsARevokedIdentity) {
  // Copies the files of the identity before the revocation, as a thief would.
  fs::copy(of("devices/robot"), of("stolen"), fs::copy_options::recursive);
  auto authority = security::Authority::open(of(""));
  ASSERT_TRUE(authority.ok()) << to_text(authority.problems());
  ASSERT_TRUE(authority->revoke({"test", Role::device, "robot"}, now_s()).ok());
  join("devices/line");
  Peer robot{{"device", "robot"}, as("stolen")};
  ASSERT_TRUE(robot.prints("ready"));
  EXPECT_TRUE(reports("device robot at 127.0.0.1: its identity was revoked"));
  std::this_thread::sleep_for(kLongEnough);
  EXPECT_THAT(heard(), IsEmpty());
}

TEST_F(Security, LetsADevicePublishOnlyItsOwnStatus) {
  join("operators/anna");
  Peer impostor{{"device", "line"}, as("devices/robot")};
  EXPECT_TRUE(reports("device robot at 127.0.0.1 publishes on takt/device for test/line"));
  Peer line{{"device", "line"}, as("devices/line")};
  EXPECT_TRUE(soon([&] { return heard().count("line") > 0; }));
}

TEST_F(Security, RejectsAWriterWithoutPermissionForItsTopic) {
  join("devices/line");
  std::atomic<int> came{0};
  auto tap = dds::Tap::create(participant_, flow("parts"),
                              [&](const std::byte*, std::size_t, std::int64_t) { ++came; });
  ASSERT_TRUE(tap.ok()) << to_text(tap.problems());

  Peer robot{{"feed", "parts", "best-effort", "1"}, as("devices/robot")};
  ASSERT_TRUE(robot.prints("ready"));
  ASSERT_TRUE(soon([&] { return (*tap)->health().matched == 1; }));

  Peer honest{{"feed", "takt/test/line/m/out", "best-effort", "1"}, as("devices/robot")};
  auto said = honest.line();
  while (said && said->starts_with("notice ")) said = honest.line();
  ASSERT_TRUE(said.has_value());
  EXPECT_THAT(*said, HasSubstr("DDS"));

  auto own = dds::Tap::create(participant_, flow("takt/test/line/m/out"),
                              [&](const std::byte*, std::size_t, std::int64_t) { ++came; });
  ASSERT_TRUE(own.ok());
  auto as_robot = as("devices/robot");
  as_robot["PEER_CHEATS"] = "1";
  Peer cheat{{"feed", "takt/test/line/m/out", "best-effort", "1"}, as_robot};
  ASSERT_TRUE(cheat.prints("ready"));
  EXPECT_TRUE(reports("device robot at 127.0.0.1 writes takt/test/line/m/out"));
  std::this_thread::sleep_for(kLongEnough);
  EXPECT_EQ((*own)->health().matched, 0U);
}

TEST_F(Security, LetsOnlyOperatorsSendCommands) {
  join("devices/robot");
  std::atomic<int> handled{0};
  dds::CommandServer* self = nullptr;
  auto server =
      dds::CommandServer::create(participant_, "robot", "node", [&](const wire::WholeCommand& command) {
        ++handled;
        wire::WholeReply reply;
        reply.head.id(command.head.id());
        reply.head.code(REPLY_OK);
        self->reply(reply);
      });
  ASSERT_TRUE(server.ok()) << to_text(server.problems());
  self = &*server;

  Peer anna{{"stop", "robot"}, as("operators/anna")};
  EXPECT_TRUE(anna.prints("answer 0 "));
  EXPECT_EQ(handled, 1);

  Peer eve{{"stop", "robot"}, as("observers/eve")};
  EXPECT_TRUE(eve.prints("answer 1 observer eve at 127.0.0.1 may only observe, not stop"));
  EXPECT_TRUE(reports("observer eve at 127.0.0.1 asked to stop, which only an operator may do"));
  EXPECT_EQ(handled, 1) << "a rejected command is not handled";
}

TEST_F(Security, RejectsAReplyInTheNameOfAnotherDevice) {
  join("operators/anna");
  Peer impostor{{"server", "line", "0"}, as("devices/robot")};
  ASSERT_TRUE(impostor.prints("ready"));
  std::atomic<int> answers{0};
  auto client = dds::CommandClient::create(participant_, [&](const wire::WholeReply&) { ++answers; });
  ASSERT_TRUE(client.ok());
  wire::WholeCommand command;
  command.head.id("1");
  command.head.device("line");
  command.head.kind(COMMAND_REPORT);
  command.head.deadline_ns(os::wall_ns() + 20'000'000'000);
  client->send(command);
  EXPECT_TRUE(reports("device robot at 127.0.0.1 publishes on takt/reply for line"));
  EXPECT_EQ(answers, 0);
}

TEST_F(Security, ReportsSettingsAndFilesThatDoNotMatchTheIdentity) {
  dds::ParticipantOptions options = on_loopback("test");
  options.security = of("devices/robot");
  options.domain = domain() + 1;
  auto made = dds::Participant::create(options);
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(to_text(made.problems()), HasSubstr("for domain " + std::to_string(domain()) + ", not for"));
  options.domain = domain();
  options.discovery.kind = model::Discovery::Kind::server;
  options.discovery.server = "127.0.0.1:11811";
  made = dds::Participant::create(options);
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(to_text(made.problems()), HasSubstr("exclude each other"));
  options.discovery = {};
  fs::remove(of("devices/robot/governance.smime"));
  made = dds::Participant::create(options);
  ASSERT_FALSE(made.ok());
  EXPECT_THAT(to_text(made.problems()), HasSubstr("governance.smime: error: there is no such file"));
}

}  // namespace
}  // namespace takt::dds_test::security_test
