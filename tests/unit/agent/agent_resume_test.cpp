#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>

#include <temporary_folder.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_resume_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;
using Phase = Supervised::Phase;

class ResumingAgent : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string folder_ = temporary_folder("agent");
  std::shared_ptr<node::DeploymentFile> file_ = std::make_shared<node::DeploymentFile>(folder_, "robot", 7);
};

TEST_F(ResumingAgent, SavesARunningDeploymentUntilItIsUndeployed) {
  FakeDevice device{file_};
  device.begin();
  EXPECT_TRUE(file_->kept()->empty()) << "the device cannot begin yet";
  device.become_prepared();
  EXPECT_TRUE(file_->kept()->pending);
  EXPECT_FALSE(file_->kept()->current);
  device.run();
  EXPECT_FALSE(file_->kept()->current) << "the other device may not be armed";
  device.start_with_line();
  const auto kept = file_->kept();
  ASSERT_TRUE(kept.ok() && kept->current);
  EXPECT_EQ(kept->current->id, "d1");
  EXPECT_EQ(kept->current->text, FakeDevice::kCell);
  EXPECT_EQ(kept->current->t0_ns, device.t0_wall);
  EXPECT_FALSE(kept->pending);
  device.undeploy();
  device.end();
  EXPECT_TRUE(file_->kept()->empty());
}

/// A disk that answers only when the test lets it.
class HangingDisk final : public DeploymentStore {
 public:
  void save(const Kept& kept, const std::vector<std::string>&) override {
    saving = kept;
    ++saves;
  }
  [[nodiscard]] std::optional<Result<void>> saved() const override {
    return hangs ? std::nullopt : std::optional<Result<void>>{Result<void>{}};
  }
  [[nodiscard]] Result<Kept> kept() const override { return Kept{}; }
  [[nodiscard]] Result<std::vector<std::string>> undeployed() const override {
    return std::vector<std::string>{};
  }
  Kept saving;
  int saves = 0;
  bool hangs = true;
};

TEST(AgentWithAHangingDisk, CanReceiveT0OnlyWhenTheDeploymentIsOnDisk) {
  const auto disk = std::make_shared<HangingDisk>();
  FakeDevice device{disk};
  device.begin();
  device.published.replies.clear();
  device.become_prepared();
  EXPECT_TRUE(disk->saving.pending);
  EXPECT_TRUE(device.published.replies.empty());
  device.run();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.status().stage(), STAGE_PREPARED);
  device.published.replies.clear();
  disk->hangs = false;
  device.agent.step();
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  device.run();
  EXPECT_EQ(device.status().stage(), STAGE_ARMED);
}

TEST(AgentWithAHangingDisk, CanBeUndeployedBeforeTheDeploymentIsOnDisk) {
  FakeDevice device{std::make_shared<HangingDisk>()};
  device.become_ready();
  device.undeploy("d1");
  EXPECT_TRUE(device.work.stop_called);
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
}

TEST(AgentWithAHangingDisk, IsFinalForOthersOnlyWhenThisIsOnDisk) {
  const auto disk = std::make_shared<HangingDisk>();
  disk->hangs = false;
  FakeDevice device{disk};
  device.become_ready();
  device.run();
  disk->hangs = true;
  device.start_with_line();
  EXPECT_TRUE(disk->saving.current);
  EXPECT_EQ(device.status().stage(), STAGE_RUNNING);
  DeviceStatus line = device.of_line(DEVICE_WAITING);
  wire::set(line.transaction(), "d1");
  line.stage(STAGE_UNDONE);
  device.agent.receive(line, FakeDevice::kLine, device.now);
  device.pass(seconds{10});
  EXPECT_FALSE(device.work.stop_called) << "line can go forward again";
  disk->hangs = false;
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
}

TEST(AgentWithAHangingDisk, DoesNotUndoAFinalDeploymentBeforeThisIsOnDisk) {
  const auto disk = std::make_shared<HangingDisk>();
  disk->hangs = false;
  FakeDevice device{disk};
  device.become_ready();
  disk->hangs = true;
  device.t0_wall = device.wall() - 500'000'000;
  device.hear_line(DEVICE_RUNNING);
  EXPECT_FALSE(device.work.t0) << "its decision is not on disk yet";
  DeviceStatus twin = device.of_line(DEVICE_RUNNING);
  wire::set(twin.device(), "robot");
  wire::set(twin.node(), "another node");
  device.agent.others().receive(twin, 5);
  device.pass(milliseconds{10});
  EXPECT_FALSE(device.work.stop_called);
}

TEST(AgentWithAHangingDisk, ConfirmsAnUndeploymentWhenItIsOnDisk) {
  const auto disk = std::make_shared<HangingDisk>();
  disk->hangs = false;
  FakeDevice device{disk};
  device.become_running();
  disk->hangs = true;
  device.undeploy("d1");
  EXPECT_TRUE(disk->saving.empty());
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING) << "the end itself does not wait for the disk";
  EXPECT_TRUE(device.published.replies.empty());
  device.agent.end(false);
  EXPECT_FALSE(device.agent.ended());
  disk->hangs = false;
  device.agent.step();
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.data()["report"]["name"], "robot");
  EXPECT_TRUE(device.agent.ended());
}

TEST_F(ResumingAgent, PassesOnAnUndeploymentFromBeforeItsRestart) {
  {
    FakeDevice device{file_};
    device.become_running();
    device.undeploy();
    device.end();
  }
  FakeDevice device{file_};
  EXPECT_EQ(device.status().undeployed().to_string(), "");
  device.hear_line(DEVICE_RUNNING);  // the other device was lost, and still runs the cell
  EXPECT_EQ(device.status().undeployed().to_string(), "d1");
}

TEST_F(ResumingAgent, DoesNotRestoreADeploymentOverANewOne) {
  {
    FakeDevice device{file_};
    device.become_running();
  }
  FakeDevice device{file_};
  device.agent.resume();
  device.prepare("d2");
  device.pass(milliseconds{301});
  EXPECT_EQ(device.status().deployment(), "d2");
  EXPECT_EQ(device.work.inspections.size(), 1U);
}

TEST_F(ResumingAgent, RestoresADeploymentOnTheSameGrid) {
  std::int64_t t0 = 0;
  {
    FakeDevice device{file_};
    device.become_running();
    t0 = file_->kept()->current->t0_ns;
    device.agent.end(false);
    device.end();
  }
  FakeDevice device{file_};
  device.now += seconds{100};
  device.resume();
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  device.work.inspected = Inspected{.paths = {"", ""}};
  device.agent.step();
  device.work.phase = Phase::ready;
  device.agent.step();
  EXPECT_EQ(device.work.t0, device.now + Nanoseconds{t0 - device.wall()});
  EXPECT_LT(*device.work.t0, device.now);
  EXPECT_EQ(file_->kept()->current->t0_ns, t0);
  EXPECT_TRUE(device.published.replies.empty()) << "no command was sent";
}

TEST_F(ResumingAgent, KeepsTheGridIfTheWallClockChangesWithinTheSameBoot) {
  Instant t0{};
  {
    FakeDevice device{file_};
    device.become_running();
    t0 = *device.work.t0;
  }
  for (const int hours : {1, -1}) {
    FakeDevice device{file_};
    device.now += seconds{100};
    device.set = std::chrono::hours{hours};
    device.resume();
    device.work.inspected = Inspected{.paths = {"", ""}};
    device.agent.step();
    device.work.phase = Phase::ready;
    device.agent.step();
    EXPECT_EQ(device.work.t0, t0) << hours;
  }
  Kept kept = *file_->kept();
  kept.current->boot = "another";
  ASSERT_TRUE(file_->keep(kept).ok());
  FakeDevice device{file_};
  device.set = std::chrono::hours{-1};
  device.resume();
  EXPECT_THAT(device.status().text().to_string(), HasSubstr("set the clock of device robot"));
}

TEST_F(ResumingAgent, RetriesAFailedSaveAndReportsItOnlyOnce) {
  std::filesystem::remove_all(folder_);
  std::ofstream{folder_} << "a file where a folder should be";
  FakeDevice device{file_};
  device.become_running();
  const auto reports = [&device] {
    return std::count_if(
        device.published.faults.begin(), device.published.faults.end(), [](const FaultEvent& event) {
          return event.cause().to_string().find("could not be saved for --resume: ") != std::string::npos;
        });
  };
  for (int i = 0; i < 100; ++i) device.pass(seconds{1});
  EXPECT_EQ(reports(), 1);
  std::filesystem::remove(folder_);
  for (int i = 0; i < 10; ++i) device.pass(seconds{1});
  ASSERT_TRUE(file_->kept().ok() && file_->kept()->current);
  EXPECT_EQ(file_->kept()->current->id, "d1");
  EXPECT_EQ(reports(), 1);
  device.undeploy();
  device.end();
  for (int i = 0; i < 10; ++i) device.pass(seconds{1});
  EXPECT_TRUE(file_->kept()->empty());
}

TEST_F(ResumingAgent, ReportsAFailedRestoreAndKeepsTheSavedDeployment) {
  {
    FakeDevice device{file_};
    device.become_running();
  }
  FakeDevice device{file_};
  device.resume();
  device.work.inspected = Problems{fail("there is no file servo.so")};
  device.agent.step();
  EXPECT_EQ(device.status().state(), DEVICE_ENDED) << "the next start of the node tries again";
  EXPECT_EQ(device.status().deployment(), "d1");
  EXPECT_EQ(device.status().health(), HEALTH_FAILED);
  EXPECT_THAT(device.status().text().to_string(), HasSubstr("no file servo.so"));
  EXPECT_FALSE(file_->kept()->empty());
  device.prepare("d2");
  EXPECT_EQ(device.text(), "device robot: it still holds cell cell, which has ended; undeploy it first");
  device.receive(device.command(COMMAND_START));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["state"], "ended");
  device.undeploy("d1");
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_OK);
  EXPECT_TRUE(file_->kept()->empty());
}

TEST_F(ResumingAgent, IsNotSaidToHaveFailedIfItsCellIsUndeployedMeanwhile) {
  {
    FakeDevice device{file_};
    device.become_running();
  }
  for (const bool elsewhere : {false, true}) {
    FakeDevice device{file_};
    device.resume();
    ASSERT_EQ(device.status().state(), DEVICE_PREPARING);
    if (elsewhere) {
      DeviceStatus line = device.of_line(DEVICE_WAITING);
      wire::set(line.undeployed(), "d1");
      device.agent.others().receive(line, FakeDevice::kLine);
      device.agent.step();
    } else {
      const auto kept = *file_->kept();
      device.undeploy();
      EXPECT_TRUE(file_->kept()->empty()) << "otherwise the next start of the node would restore it";
      ASSERT_TRUE(file_->keep(kept).ok());
    }
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_EQ(device.status().health(), HEALTH_OK);
    EXPECT_EQ(device.logged.back(), "cell cell is undeployed");
  }
}

TEST_F(ResumingAgent, HasUndoneADeploymentIfItsNodeIsRestartedBeforeAllDevicesRun) {
  std::int64_t t0 = 0;
  {
    FakeDevice device{file_};
    device.become_ready();
    device.run();
    t0 = device.t0_wall;
  }
  FakeDevice device{file_};
  device.resume();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  EXPECT_EQ(device.logged.back(), "cell cell is not restored: it was undone before all devices ran");
  device.t0_wall = t0;
  DeviceStatus line = device.of_line(DEVICE_WAITING);
  wire::set(line.transaction(), "d1");
  line.stage(STAGE_PREPARED);
  device.agent.others().receive(line, FakeDevice::kLine);
  device.agent.step();
  EXPECT_FALSE(file_->kept()->empty()) << "line may become final";
  line.stage(STAGE_UNDONE);
  device.agent.others().receive(line, FakeDevice::kLine);
  device.agent.step();
  EXPECT_TRUE(file_->kept()->empty()) << "no device can be final any more";
}

TEST_F(ResumingAgent, BeginsAnUndoneDeploymentIfAnotherDeviceIsFinal) {
  std::int64_t t0 = 0;
  {
    FakeDevice device{file_};
    device.become_ready();
    t0 = device.wall() + 100'000'000;
  }
  FakeDevice device{file_};
  device.resume();
  device.t0_wall = t0;
  device.hear_line(DEVICE_RUNNING);
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  EXPECT_TRUE(file_->kept()->current);
  EXPECT_EQ(file_->kept()->current->t0_ns, t0) << "this device has received T0 from line only";
  device.work.inspected = Inspected{.paths = {"", ""}};
  device.agent.step();
  device.work.phase = Phase::ready;
  device.agent.step();
  EXPECT_EQ(device.work.t0, device.now + Nanoseconds{t0 - device.wall()});
}

TEST_F(ResumingAgent, RejectsASavedDeploymentThatStartsFarInTheFuture) {
  {
    FakeDevice device{file_};
    device.become_running();
  }
  const Kept kept = *file_->kept();
  for (const std::int64_t ahead :
       {std::int64_t{3600'000'000'000}, std::numeric_limits<std::int64_t>::max() - kept.current->t0_ns}) {
    Kept later = kept;
    later.current->t0_ns += ahead;
    later.current->boot = "another";
    ASSERT_TRUE(file_->keep(later).ok());
    FakeDevice device{file_};
    device.resume();
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_EQ(device.status().health(), HEALTH_FAILED);
    EXPECT_THAT(device.status().text().to_string(), HasSubstr("set the clock of device robot"));
    EXPECT_FALSE(file_->kept()->empty());
  }
}

TEST_F(ResumingAgent, ReportsADamagedFileUntilTheNextDeployment) {
  {
    FakeDevice device{file_};
    device.become_running();
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    std::filesystem::resize_file(entry.path(), 100);
  FakeDevice device{file_};
  device.resume();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_FAILED);
  EXPECT_THAT(device.status().text().to_string(), HasSubstr("damaged"));
  device.become_running();
  EXPECT_EQ(device.status().health(), HEALTH_OK);
}

TEST_F(ResumingAgent, WaitsForADeploymentIfNoneIsSaved) {
  FakeDevice device{file_};
  device.resume();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_OK);
}

}  // namespace
}  // namespace takt::agent::agent_resume_test
