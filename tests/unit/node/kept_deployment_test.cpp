#include <takt/node/kept_deployment.hpp>

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <temporary_folder.hpp>

#include <takt/os/clock.hpp>
#include "whole_file.hpp"

namespace takt::node::kept_deployment_test {
namespace {

using namespace std::string_literals;
using testing::HasSubstr;

class StoredDeployment : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::string content() const {
    std::ostringstream text;
    text << std::ifstream{file_.path()}.rdbuf();
    return text.str();
  }
  void write(const std::string& text) const { std::ofstream{file_.path()} << text; }

  std::string folder_ = temporary_folder("kept");
  DeploymentFile file_{folder_, "robot", 7};
  agent::KeptDeployment deployment_{.id = "a1",
                                    .transaction = "a2",
                                    .file = "cell.xml",
                                    .text = "<cell name=\"\u00e9\">\n\"\\</cell>",
                                    .require_real_time = true,
                                    .t0_ns = 1'700'000'000'123'456'789,
                                    .boot = "3f1c",
                                    .t0_monotonic_ns = 123'456'789,
                                    .safe = "[]",
                                    .devices = {"robot", "line"}};
  agent::Kept kept_{.current = deployment_};
};

TEST_F(StoredDeployment, IsAbsentAtFirst) {
  const auto kept = file_.kept();
  ASSERT_TRUE(kept.ok());
  EXPECT_TRUE(kept->empty());
  EXPECT_TRUE(file_.keep({}).ok());
}

TEST_F(StoredDeployment, CanBeReadBackUntilItIsForgotten) {
  agent::Kept both = kept_;
  both.pending = deployment_;
  both.pending->transaction = "a3";
  for (const agent::Kept& kept : {kept_, both, agent::Kept{.pending = deployment_}}) {
    ASSERT_TRUE(file_.keep(kept).ok());
    EXPECT_EQ(*file_.kept(), kept);
  }
  ASSERT_TRUE(file_.keep({}).ok());
  EXPECT_TRUE(file_.kept()->empty());
}

TEST_F(StoredDeployment, IsRejectedIfItsFileIsTruncated) {
  ASSERT_TRUE(file_.keep(kept_).ok());
  const std::string whole = content();
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write(whole.substr(0, length));
    const auto kept = file_.kept();
    ASSERT_FALSE(kept.ok()) << length;
    EXPECT_THAT(to_text(kept.problems()), HasSubstr("damaged"));
  }
}

TEST_F(StoredDeployment, IsRejectedIfAnyByteChanged) {
  ASSERT_TRUE(file_.keep(kept_).ok());
  const std::string whole = content();
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string changed = whole;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    write(changed);
    ASSERT_FALSE(file_.kept().ok()) << at;
  }
}

TEST_F(StoredDeployment, IsRejectedIfItsTimeIsInvalid) {
  for (const char* other : {"-1", "0", "1.5", "1e300", "9223372036854775808", "\"1\"", "null"}) {
    for (const char* part : {R"("t0_ns":1)", R"("t0_monotonic_ns":1)"}) {
      const std::string name = std::string{part}.substr(0, std::string{part}.size() - 1);
      // A negative time is valid: it is a time before the boot of the machine.
      if (name == R"("t0_monotonic_ns":)" && std::string{other}.size() <= 2) continue;
      std::string body =
          R"({"current":{"id":"a","transaction":"a","file":"f","text":"","require_real_time":false,"boot":"3f1c",)"
          R"("t0_ns":1,"t0_monotonic_ns":1,"safe":"","devices":[]},"pending":null})";
      ASSERT_TRUE(write_whole(file_.path(), "takt deployment 4", body).ok());
      ASSERT_TRUE(file_.kept().ok());
      body.replace(body.find(part), std::string{part}.size(), name + other);
      ASSERT_TRUE(write_whole(file_.path(), "takt deployment 4", body).ok());
      const auto kept = file_.kept();
      ASSERT_FALSE(kept.ok()) << body;
      EXPECT_THAT(to_text(kept.problems()), HasSubstr("damaged"));
    }
  }
}

TEST_F(StoredDeployment, HasItsOwnFilePerDeviceAndDomain) {
  ASSERT_TRUE(file_.keep(kept_).ok());
  EXPECT_TRUE((DeploymentFile{folder_, "robot", 8}).kept()->empty());
  EXPECT_TRUE((DeploymentFile{folder_, "line", 7}).kept()->empty());
}

TEST_F(StoredDeployment, IsRejectedIfOtherUsersCanReplaceItsFile) {
  ASSERT_TRUE(file_.keep(kept_).ok());
  std::filesystem::permissions(folder_, std::filesystem::perms::all);
  const auto kept = file_.kept();
  ASSERT_FALSE(kept.ok());
  EXPECT_THAT(to_text(kept.problems()), HasSubstr("everybody may write to " + folder_ + " "));
  EXPECT_THAT(to_text(kept.problems()), HasSubstr("run chmod o-w " + folder_));
}

TEST_F(StoredDeployment, HasAFileThatListsTheUndeployedDeployments) {
  EXPECT_EQ(*file_.undeployed(), std::vector<std::string>{});
  const std::vector<std::string> ids{"a1", "\"a2\""};
  ASSERT_TRUE(file_.keep_undeployed(ids).ok());
  EXPECT_EQ(*file_.undeployed(), ids);
  std::ofstream{folder_ + "/robot.7.undeployed"} << "takt undeployed 1 00000000\n[1]";
  const auto damaged = file_.undeployed();
  ASSERT_FALSE(damaged.ok());
  EXPECT_THAT(to_text(damaged.problems()), HasSubstr("robot.7.undeployed: error: the saved list"));
}

TEST_F(StoredDeployment, IsWrittenByAThreadAndTheNewestOneWins) {
  {
    const auto writer = DeploymentWriter::create(file_);
    ASSERT_TRUE(writer.ok());
    EXPECT_FALSE((*writer)->saved());
    for (int i = 0; i <= 100; ++i) {
      kept_.current->id = "a" + std::to_string(i);
      (*writer)->save(kept_, {std::to_string(i)});
    }
    while (!(*writer)->saved()) os::sleep_until(os::now() + std::chrono::milliseconds{1});
    EXPECT_TRUE((*writer)->saved()->ok());
    EXPECT_EQ(*(*writer)->kept(), kept_);
    EXPECT_EQ(*(*writer)->undeployed(), std::vector<std::string>{"100"});
  }
  EXPECT_EQ(*file_.kept(), kept_);
  const auto nowhere = DeploymentWriter::create({"/proc/takt", "robot", 0});
  (*nowhere)->save(kept_, {});
  while (!(*nowhere)->saved()) os::sleep_until(os::now() + std::chrono::milliseconds{1});
  EXPECT_THAT(to_text((*nowhere)->saved()->problems()), HasSubstr("/proc/takt"));
}

TEST_F(StoredDeployment, CannotBeStoredInAnUnwritableFolder) {
  const DeploymentFile nowhere{"/proc/takt", "robot", 0};
  const auto kept = nowhere.keep(kept_);
  ASSERT_FALSE(kept.ok());
  EXPECT_THAT(to_text(kept.problems()), HasSubstr("/proc/takt"));
}

TEST(StateFolder, CanBeSetByAnEnvironmentVariable) {
  ::setenv("TAKT_STATE_DIR", "/somewhere", 1);
  EXPECT_EQ(default_state_folder(), "/somewhere");
  ::unsetenv("TAKT_STATE_DIR");
  EXPECT_THAT(default_state_folder(), HasSubstr("takt"));
}

}  // namespace
}  // namespace takt::node::kept_deployment_test
