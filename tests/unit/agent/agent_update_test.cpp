#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <temporary_folder.hpp>
#include <takt/wire/words.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_update_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Phase = Supervised::Phase;

/// Returns `text`, by default the descriptor of the cell, with `part` replaced by `other`.
std::string with(const std::string& part, const std::string& other, std::string text = FakeDevice::kCell) {
  const auto at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return text.replace(at, part.size(), other);
}
constexpr const char* kArmBefore = "<name>arm</name><filename>arm.so</filename>";
const std::string kFile = with(kArmBefore, "<name>arm</name><filename>arm2.so</filename>");
const std::string kPeriod =
    with("<period>1000000</period><priority>2", "<period>2000000</period><priority>2");
const std::string kGain1 = with("<priority>2</priority>",
                                "<priority>2</priority><property><value name=\"gain\">1</value></property>");
const std::string kGain2 = with("<value name=\"gain\">1", "<value name=\"gain\">2", kGain1);
constexpr const char* kDeclares = R"({"modules": [{"name": "servo", "properties": []},
  {"name": "arm", "properties": [{"name": "gain"}]}]})";

class AgentUpdate : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(folder_); }

  void start_running(const std::string& text = FakeDevice::kCell) {
    device.become_running(text);
    for (const std::uint32_t module : {0U, 1U})
      device.work.stepped({.module = module, .transition = {.to = lifecycle::State::executing}});
    device.work.inspected = Inspected{.paths = {"/servo.so", "/arm2.so"}, .description = kDeclares};
  }
  wire::WholeCommand step(CommandKind kind, const std::string& id = "u1") {
    wire::WholeCommand command = device.command(kind);
    command.head.deployment(device.id);
    command.head.property(id);
    if (kind == COMMAND_CHANGE) command.data = R"({"devices": ["robot", "line"], "safe": []})";
    return command;
  }
  /// Sends a command and returns the reply. Returns null if the agent has not replied yet.
  const Reply* send(const wire::WholeCommand& command) {
    device.receive(command);
    device.agent.step();
    return answer_to(command);
  }
  const Reply* answer_to(const wire::WholeCommand& command) {
    const Reply* found = nullptr;
    for (const wire::WholeReply& reply : device.published.replies) {
      if (reply.head.id() != command.head.id()) continue;
      EXPECT_EQ(found, nullptr) << "the command was answered twice";
      found = &reply.head;
    }
    return found;
  }
  bool accepts(const std::string& text, const std::string& id = "u1") {
    wire::WholeCommand command = step(COMMAND_PREPARE, id);
    command.head.value("new.xml");
    command.data = text;
    const Reply* const reply = send(command);
    return reply != nullptr && reply->code() == REPLY_OK;
  }
  /// Completes the operation that the agent started last on the device, with this outcome.
  void done(ReplyCode code = REPLY_OK, const std::string& value = "", const std::string& text = "") {
    ASSERT_FALSE(device.work.done.empty());
    const auto one = device.work.done.back();
    device.work.done.pop_back();
    one({.code = code, .state = lifecycle::State::executing, .text = text, .value = value});
    device.agent.step();
  }
  /// Receives a status from other devices of the cell, which reports this stage of the update.
  void others_say(TransactionStage stage, const std::string& id = "u1",
                  const std::vector<std::string>& names = {"line"}) {
    wire::WriterId writer = FakeDevice::kLine;
    for (const std::string& name : names) {
      DeviceStatus status = device.of_line(DEVICE_RUNNING);
      wire::set(status.device(), name);
      wire::set(status.node(), "node of " + name);
      wire::set(status.transaction(), id);
      status.stage(stage);
      device.agent.others().receive(status, writer++);
    }
    device.agent.step();
  }
  /// Sends T0 of the update, which is half a second ahead.
  const Reply* send_t0(const std::string& id = "u1") {
    wire::WholeCommand run = step(COMMAND_RUN, id);
    device.t0_wall = device.wall() + 500'000'000;
    run.head.time_ns(device.t0_wall);
    return send(run);
  }
  /// The update succeeds: all devices get T0, and then hear from each other that they have it.
  void keep(const std::string& id = "u1", const std::vector<std::string>& names = {"line"}) {
    EXPECT_EQ(send_t0(id)->code(), REPLY_OK);
    others_say(STAGE_ARMED, id, names);
    device.pass(milliseconds{500} - transaction::kBegins);
    EXPECT_EQ(device.status().stage(), STAGE_RUNNING);
    device.pass(transaction::kBegins);
    others_say(STAGE_RUNNING, id, names);
    EXPECT_EQ(device.status().stage(), STAGE_FINAL);
    others_say(STAGE_FINAL, id, names);
  }
  /// The other device is lost after both have T0, so this device undoes the update.
  void lose_line_after_t0() {
    send_t0();
    others_say(STAGE_ARMED);
    device.pass(milliseconds{500});
    EXPECT_EQ(device.status().stage(), STAGE_RUNNING);
    device.agent.others().lost(FakeDevice::kLine);
    device.pass(transaction::kHeardWithin + milliseconds{1});
    EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  }
  /// Changes a property of arm. Both devices have T0.
  void change_gain_and_send_t0() {
    start_running(kGain1);
    ASSERT_TRUE(accepts(kGain2));
    send(step(COMMAND_CHANGE));
    done(REPLY_OK, "1");
    done();
    send_t0();
    others_say(STAGE_ARMED);
  }
  void end_device() { device.end(); }
  /// Lets every module reach START. The node of the other device is there.
  void become_ready() {
    device.work.phase = Phase::ready;
    device.agent.receive(device.of_line(DEVICE_RUNNING), FakeDevice::kLine, device.now);
    device.agent.step();
  }

  std::string folder_ = temporary_folder("update");
  std::shared_ptr<node::DeploymentFile> file_ = std::make_shared<node::DeploymentFile>(folder_, "robot", 7);
  FakeDevice device{file_};
};

TEST_F(AgentUpdate, OnlySavesTheDescriptorIfNoModuleChanges) {
  start_running();
  ASSERT_TRUE(accepts(with("</cell>", "<!-- the same --></cell>")));
  EXPECT_EQ(device.data()["change"], "none");
  EXPECT_EQ(device.data()["words"].size(), 0U);
  EXPECT_EQ(device.data()["modules"].size(), 2U)
      << "the reply lists each module with its ports, so that connections from other devices can be checked";
  EXPECT_EQ(send(step(COMMAND_CHANGE))->code(), REPLY_OK);
  keep();
  EXPECT_THAT(file_->kept()->current->text, HasSubstr("the same"));
  EXPECT_FALSE(device.work.stop_called);
  EXPECT_EQ(device.work.inspections.size(), 2U) << "the files may have been rebuilt";
}

TEST_F(AgentUpdate, InspectsAChangedComponentBeforeTheSwap) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  EXPECT_EQ(device.data()["change"], "in place");
  EXPECT_EQ(device.data()["words"][0], "robot.arm: file: arm.so -> arm2.so");
  EXPECT_THAT(device.work.swaps, IsEmpty());
  const auto change = step(COMMAND_CHANGE);
  EXPECT_EQ(send(change), nullptr);
  EXPECT_THAT(device.work.swaps, ElementsAre(std::pair{1U, std::string{"/arm2.so"}}));
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell) << "the update can still be undone";
  EXPECT_EQ(file_->kept()->pending->text, kFile) << "another device may become final";
  keep();
  EXPECT_EQ(file_->kept()->current->text, kFile);
  EXPECT_EQ(file_->kept()->current->file, "new.xml");
  EXPECT_EQ(file_->kept()->current->transaction, "u1");
  EXPECT_FALSE(file_->kept()->pending);
  EXPECT_FALSE(device.work.stop_called);
  EXPECT_THAT(device.published.faults.back().cause().to_string(),
              HasSubstr("update to new.xml was carried out"));
}

TEST_F(AgentUpdate, RestoresThePropertyValueThatAnOperatorHadSet) {
  start_running(kGain1);
  ASSERT_TRUE(accepts(kGain2));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  done(REPLY_OK, "1.5");  // the value that the property has now, set by an operator
  EXPECT_EQ(device.work.properties.back(), "1 gain = 2");
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(send(back), nullptr);
  EXPECT_EQ(device.work.properties.back(), "1 gain = 1.5");
  done();
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(answer_to(back)->value(), wire::kAsBefore);
  EXPECT_EQ(file_->kept()->current->text, kGain1);
  EXPECT_FALSE(accepts(kGain2, "u2"));
  EXPECT_THAT(device.text(),
              HasSubstr("device line has not decided about the last deployment or update yet"));
  others_say(STAGE_UNDONE);
  EXPECT_FALSE(file_->kept()->pending) << "no device can be final any more";
  EXPECT_TRUE(accepts(kGain2, "u2"));
}

TEST_F(AgentUpdate, UndoesEarlierChangesWhenAStepFails) {
  start_running();
  ASSERT_TRUE(accepts(
      with("<priority>1</priority>",
           "<priority>1</priority><property><value name=\"log-level\">debug</value></property>", kFile)));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  done(REPLY_OK, "info");
  EXPECT_EQ(device.work.properties.back(), "0 log-level = debug");
  done();
  done(REPLY_FAILED, "", "the third is not for me");  // the swap fails with this text
  EXPECT_EQ(answer_to(change), nullptr);
  EXPECT_EQ(device.work.properties.back(), "0 log-level = info");
  done();
  ASSERT_NE(answer_to(change), nullptr);
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_THAT(answer_to(change)->text().to_string(), HasSubstr("the third is not for me"));
  EXPECT_EQ(answer_to(change)->value(), wire::kAsBefore);
  const auto says_why = [](const FaultEvent& event) {
    return event.cause().to_string().find("the third is not for me") != std::string::npos;
  };
  const auto& faults = device.published.faults;
  EXPECT_EQ(std::count_if(faults.begin(), faults.end(), says_why), 1) << "the failure is recorded once";
}

TEST_F(AgentUpdate, GivesOnlyTheNewInstanceTheNewPropertyValue) {
  start_running(kGain1);
  ASSERT_TRUE(accepts(with(kArmBefore, "<name>arm</name><filename>arm2.so</filename>", kGain2)));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  done(REPLY_OK, "1.5");
  EXPECT_THAT(device.work.properties, ElementsAre("1 gain")) << "the old instance keeps its value";
  EXPECT_THAT(device.work.swaps, ElementsAre(std::pair{1U, std::string{"/arm2.so gain = 2"}}));
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  const auto back = step(COMMAND_PUT_BACK);
  send(back);
  EXPECT_EQ(device.work.swaps.back().second, "/arm.so gain = 1.5");
  done();
  EXPECT_EQ(answer_to(back)->value(), wire::kAsBefore);
  EXPECT_THAT(device.work.properties, ElementsAre("1 gain"));
}

TEST_F(AgentUpdate, RestartsTheDeviceIfAChangeCannotBeUndoneWhileItRuns) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  const auto back = step(COMMAND_PUT_BACK);
  send(back);
  done(REPLY_FAILED, "", "restore() refused");
  EXPECT_EQ(answer_to(back), nullptr);
  EXPECT_THAT(device.logged.back(), HasSubstr("is restarted to undo the update, because arm cannot be "
                                              "changed while it runs: restore() refused"));
  EXPECT_TRUE(device.work.stop_called);
  device.work.failures = {fail("arm was given up")};
  end_device();
  EXPECT_THAT(device.work.paths, ElementsAre("/servo.so", "/arm.so"));
  become_ready();
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(answer_to(back)->value(), wire::kAsBefore);
  for (const FaultEvent& event : device.published.faults)
    EXPECT_THAT(event.cause().to_string(), testing::Not(HasSubstr("has ended")));
}

TEST_F(AgentUpdate, IsUndoneIfAChangedModuleFailsBeforeT0) {
  change_gain_and_send_t0();
  device.work.stepped({.module = 0, .transition = {.to = lifecycle::State::recover}, .text = "crash"});
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_ARMED) << "the update does not change this module";
  device.work.stepped({.module = 1,
                       .transition = {.to = lifecycle::State::recover},
                       .error = ErrorType::stale,
                       .text = "old"});
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_ARMED) << "its input comes from a device that the update restarts";
  device.work.stepped({.module = 1,
                       .transition = {.to = lifecycle::State::destruct, .event = lifecycle::Event::give_up},
                       .text = "crash; run takt restart robot.arm"});
  device.work.failures = {{"module robot.arm", "crash", ""}};
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  EXPECT_EQ(device.work.properties.back(), "1 gain = 1");
  const std::string why = "module robot.arm: gain: 1 -> 2: it went to DESTRUCT: crash";
  EXPECT_EQ(send_t0()->text(), why);
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(send(back), nullptr);
  done(REPLY_REFUSED, "", "it is in DESTRUCT");
  EXPECT_TRUE(device.work.stop_called);
  end_device();
  EXPECT_EQ(device.work.cell.devices[0].modules[1].properties.at(0).value, "1");
  become_ready();
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(answer_to(back)->text(), why) << "the client may not know the reason yet";
  const FaultEvent& event = device.published.faults.back();
  EXPECT_EQ(event.cause().to_string(), "update to new.xml was undone: " + why);
  EXPECT_THAT(send(step(COMMAND_PUT_BACK))->text().to_string(), HasSubstr("it has undone this: " + why));
}

TEST_F(AgentUpdate, IsKeptIfAChangedModuleFailsAfterT0) {
  change_gain_and_send_t0();
  device.pass(milliseconds{500});
  device.work.stepped({.module = 1, .transition = {.to = lifecycle::State::recover}, .text = "crash"});
  others_say(STAGE_RUNNING);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
}

TEST_F(AgentUpdate, RestartsTheDeviceIfAChangedPropertyIsNotDeclared) {
  start_running(kGain1);
  device.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}, .description = R"({"modules": []})"};
  ASSERT_TRUE(accepts(kGain2));
  EXPECT_EQ(device.data()["change"], "anew");
  EXPECT_THAT(device.data()["words"][0].get<std::string>(),
              HasSubstr("module arm reads property gain only in initialize()"));
}

TEST_F(AgentUpdate, SetsTheLogLevelOfAnyModuleInAnyStateWithoutARestart) {
  start_running(kGain1);
  device.work.stepped({.module = 1, .transition = {.to = lifecycle::State::destruct}});
  device.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}, .description = R"({"modules": []})"};
  ASSERT_TRUE(accepts(
      with("<value name=\"gain\">", "<value name=\"log-level\">debug</value><value name=\"gain\">", kGain1)));
  EXPECT_EQ(device.data()["change"], "in place");
  send(step(COMMAND_CHANGE));
  done(REPLY_OK, "info");
  EXPECT_EQ(device.work.properties.back(), "1 log-level = debug");
}

TEST_F(AgentUpdate, RestartsTheDeviceForAComponentWithOtherPorts) {
  start_running();
  device.work.inspected = Inspected{.paths = {"", ""}, .ports = {std::nullopt, std::vector<model::Port>(1)}};
  ASSERT_TRUE(accepts(kFile));
  EXPECT_EQ(device.data()["change"], "anew");
  EXPECT_THAT(device.data()["words"][0].get<std::string>(),
              HasSubstr("module arm has different ports in its new file"));
}

Inspected built(const std::string& servo, const std::string& arm) {
  return {.paths = {"/servo.so", "/arm.so"}, .builds = {{.hash = servo}, {.version = "2", .hash = arm}}};
}

TEST_F(AgentUpdate, SwapsAModuleWhoseFileWasRebuiltUnderTheSameName) {
  device.become_running(FakeDevice::kCell, built("11", "22"));
  device.work.inspected = built("11", "22");
  ASSERT_TRUE(accepts(FakeDevice::kCell));
  EXPECT_EQ(device.data()["change"], "none");
  send(step(COMMAND_CHANGE));
  keep();

  device.work.inspected = built("11", "33");
  ASSERT_TRUE(accepts(FakeDevice::kCell, "u2"));
  EXPECT_EQ(device.data()["change"], "in place");
  EXPECT_THAT(device.data()["words"], ElementsAre("robot.arm: file arm.so: 2 22 -> 2 33"));
  send(step(COMMAND_CHANGE, "u2"));
  EXPECT_THAT(device.work.swaps, ElementsAre(std::pair{1U, std::string{"/arm.so"}}));
  done();
  keep("u2");

  ASSERT_TRUE(accepts(FakeDevice::kCell, "u3"));
  EXPECT_EQ(device.data()["change"], "none") << "the running build was not recorded";
}

TEST_F(AgentUpdate, ReportsThatAFileReplacedUnderTheSameNameCannotBePutBack) {
  device.become_running(FakeDevice::kCell, built("11", "22"));
  device.work.inspected = built("11", "33");
  ASSERT_TRUE(accepts(FakeDevice::kCell));
  send(step(COMMAND_CHANGE));
  done();
  const auto back = step(COMMAND_PUT_BACK);
  send(back);
  EXPECT_EQ(device.work.swaps.size(), 1U);
  EXPECT_THAT(answer_to(back)->text().to_string(),
              HasSubstr("module robot.arm: its change could not be undone"));
}

TEST_F(AgentUpdate, RejectsAnUpdateWhenAModuleCannotBeSwapped) {
  start_running();
  device.work.may_swap = fail("module robot.arm is in START");
  EXPECT_FALSE(accepts(kFile));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("is in START"));
}

TEST_F(AgentUpdate, RejectsAPropertyChangeForAModuleThatAnOperatorHasEnded) {
  start_running(kGain1);
  device.work.stepped({.module = 1, .transition = {.to = lifecycle::State::destruct}});
  EXPECT_FALSE(accepts(kGain2));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("module robot.arm: it is in DESTRUCT"));
  EXPECT_THAT(device.text(), HasSubstr("run takt restart robot.arm first"));
}

TEST_F(AgentUpdate, RestartsTheDeviceIfAChangedModuleWasGivenUp) {
  start_running(kGain1);
  device.work.stepped({.module = 1, .transition = {.to = lifecycle::State::recover}});
  ASSERT_TRUE(accepts(kGain2));
  EXPECT_EQ(device.data()["change"], "in place") << "the value may help the module to recover";
  send(step(COMMAND_PUT_BACK));
  device.work.stepped(
      {.module = 1, .transition = {.to = lifecycle::State::destruct, .event = lifecycle::Event::give_up}});
  device.work.may_swap = fail("it is in DESTRUCT");
  ASSERT_TRUE(accepts(with(kArmBefore, "<name>arm</name><filename>arm2.so</filename>", kGain2), "u2"));
  EXPECT_EQ(device.data()["words"][0],
            "robot is restarted: module arm was given up; module arm: gain: 1 -> 2; module arm: file: arm.so "
            "-> arm2.so");
}

TEST_F(AgentUpdate, KeepsTheGridWhenItRestartsTheDevice) {
  start_running();
  const auto t0 = device.work.t0;
  device.now += seconds{100};
  ASSERT_TRUE(accepts(kPeriod));
  EXPECT_EQ(device.data()["words"][0], "robot is restarted: module arm: period: 1 ms -> 2 ms");
  EXPECT_FALSE(device.work.stop_called);
  const auto change = step(COMMAND_CHANGE);
  EXPECT_EQ(send(change), nullptr);
  EXPECT_TRUE(device.work.stop_called);
  device.work.t0.reset();
  end_device();
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  EXPECT_EQ(device.status().deployment(), "d1") << "for other devices it is the same deployment";
  EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{2});
  EXPECT_EQ(device.work.inspections.size(), 2U) << "the inspection came before the device was stopped";
  become_ready();
  EXPECT_FALSE(device.work.t0) << "it begins at T0 of the update";
  EXPECT_EQ(device.status().state(), DEVICE_READY);
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell);
  keep();
  EXPECT_EQ(device.work.t0, t0);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(file_->kept()->current->text, kPeriod);
  for (const FaultEvent& event : device.published.faults)
    EXPECT_NE(event.kind(), FAULT_UNDEPLOYED) << event.cause();
}

TEST_F(AgentUpdate, RestoresTheOldDeploymentWhenTheNewOneCannotStart) {
  start_running();
  const auto t0 = device.work.t0;
  ASSERT_TRUE(accepts(kPeriod));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  end_device();
  device.work.failures = {fail("servo cannot be initialised")};
  end_device();
  device.work.failures.clear();
  EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{1});
  device.work.t0.reset();
  become_ready();
  EXPECT_EQ(device.work.t0, t0);
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_THAT(answer_to(change)->text().to_string(), HasSubstr("servo cannot be initialised"));
  EXPECT_EQ(answer_to(change)->value(), wire::kAsBefore);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell);
}

TEST_F(AgentUpdate, RestoresTheOldDeploymentWhenTheNewOneEndsBeforeTheUpdateIsFinal) {
  enum class When { before_t0, after_t0, after_t0_and_stops_the_cell };
  start_running();
  int number = 0;
  for (const When when : {When::before_t0, When::after_t0, When::after_t0_and_stops_the_cell}) {
    const std::string id = "u" + std::to_string(++number);
    const bool ends = when == When::after_t0_and_stops_the_cell;
    ASSERT_TRUE(accepts(kPeriod, id)) << device.text();
    send(step(COMMAND_CHANGE, id));
    end_device();
    become_ready();
    if (when != When::before_t0) {
      send_t0(id);
      others_say(STAGE_ARMED, id);
      device.pass(milliseconds{500});
      EXPECT_EQ(device.status().state(), DEVICE_STARTED);
    }
    device.work.failures = {fail("the host has ended")};
    device.work.stops_cell = when != When::after_t0;
    end_device();
    EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
    EXPECT_EQ(device.status().state(), ends ? DEVICE_ENDED : DEVICE_PREPARING);
    EXPECT_EQ(device.status().stops_cell(), ends) << "before T0, no module has run that could stop the cell";
    if (!ends) {
      device.work.failures.clear();
      device.work.stops_cell = false;
      EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{1});
      become_ready();
      EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
    }
    others_say(STAGE_UNDONE, id);
    EXPECT_FALSE(file_->kept()->pending);
    EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell);
  }
}

TEST_F(AgentUpdate, FailsIfNeitherTheNewNorTheOldDeploymentCanStart) {
  start_running();
  ASSERT_TRUE(accepts(kPeriod));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  end_device();
  device.work.failures = {fail("servo cannot be initialised")};
  end_device();
  end_device();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_EQ(answer_to(change)->value(), "");
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_FAILED);
  EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell) << "--resume can try again";
}

TEST_F(AgentUpdate, RestoresARestartedDeviceWhenAnotherDeviceFails) {
  start_running();
  ASSERT_TRUE(accepts(kPeriod));
  send(step(COMMAND_CHANGE));
  end_device();
  become_ready();
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(send(back), nullptr);
  end_device();
  EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{1});
  become_ready();
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
}

TEST_F(AgentUpdate, KeepsOperatorChangesThatTheNewDescriptorDoesNotOverride) {
  start_running(kGain1);
  wire::WholeCommand set = device.command(COMMAND_SET);
  set.head.module_name("arm");
  set.head.property("gain");
  set.head.value("7");
  send(set);
  done();
  set.head.property("log-level");
  set.head.value("debug");
  send(set);
  done();
  wire::WholeCommand swap = device.command(COMMAND_SWAP);
  swap.head.module_name("servo");
  swap.head.value("servo9.so");
  device.work.inspected = Inspected{.paths = {"/servo9.so"}};
  send(swap);
  done();
  device.work.inspected = Inspected{.paths = {"/servo9.so", "/arm.so"}};
  ASSERT_TRUE(
      accepts(with("<period>1000000</period><priority>2", "<period>2000000</period><priority>2", kGain1)));
  EXPECT_EQ(device.work.inspections.back().swapped.at("servo"), "/servo9.so");
  send(step(COMMAND_CHANGE));
  end_device();
  EXPECT_EQ(*model::given_property(device.work.cell.devices[0].modules[1], "gain"), "7");
  EXPECT_EQ(*model::given_property(device.work.cell.devices[0].modules[1], "log-level"), "debug");
  EXPECT_THAT(device.work.paths, ElementsAre("/servo9.so", "/arm.so"));
  become_ready();
  keep();
  // The new descriptor changes `gain` and the file of servo. So the values of the descriptor replace the
  // values that the operator has set.
  device.work.inspected = Inspected{.paths = {"", ""}, .description = "{}"};
  ASSERT_TRUE(accepts(with("servo.so", "servo1.so", kGain2), "u2"));
  EXPECT_THAT(device.work.inspections.back().swapped, IsEmpty());
  send(step(COMMAND_CHANGE, "u2"));
  end_device();
  EXPECT_EQ(*model::given_property(device.work.cell.devices[0].modules[1], "gain"), "2");
}

TEST_F(AgentUpdate, StartsAnAddedDeviceOnTheGridOfTheOtherDevices) {
  device.work.inspected = Inspected{.paths = {"", ""}};
  ASSERT_TRUE(accepts(FakeDevice::kCell));
  EXPECT_EQ(device.data()["change"], "added");
  EXPECT_FALSE(device.data().contains("t0_ns")) << "a device without a deployment has no T0";
  auto change = step(COMMAND_CHANGE);
  change.head.time_ns(device.wall() - 10'000'000'000);
  EXPECT_EQ(send(change), nullptr);
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  const Instant grid = device.now - seconds{10};
  become_ready();
  EXPECT_FALSE(device.work.t0) << "it begins at T0 of the update";
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  EXPECT_FALSE(file_->kept()->current);
  EXPECT_EQ(file_->kept()->pending->id, "d1");
  keep();
  EXPECT_EQ(device.work.t0, grid);
  EXPECT_EQ(file_->kept()->current->id, "d1");
  EXPECT_EQ(file_->kept()->current->t0_ns, change.head.time_ns());
}

TEST_F(AgentUpdate, StopsAnAddedDeviceWhenTheUpdateIsUndone) {
  device.work.inspected = Inspected{.paths = {"", ""}};
  ASSERT_TRUE(accepts(FakeDevice::kCell));
  auto change = step(COMMAND_CHANGE);
  change.head.time_ns(device.wall());
  send(change);
  become_ready();
  const auto back = step(COMMAND_PUT_BACK);
  send(back);
  end_device();
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
}

TEST_F(AgentUpdate, CanRestoreADeviceThatItRemoved) {
  for (const bool kept : {false, true}) {
    FakeDevice fresh{file_};
    start_running();
    const std::string id = kept ? "u2" : "u1";
    ASSERT_TRUE(accepts(with("name=\"robot\"", "name=\"other\""), id));
    EXPECT_EQ(device.data()["change"], "removed");
    auto change = step(COMMAND_CHANGE, id);
    change.data = R"({"devices": ["robot", "line", "other"], "safe": []})";
    send(change);
    end_device();
    EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell);
    EXPECT_EQ(file_->kept()->pending->text, "");
    if (kept) {
      keep(id, {"line", "other"});
      EXPECT_EQ(device.status().transaction(), id) << "the other devices must hear that it is final";
      EXPECT_TRUE(file_->kept()->empty());
      break;
    }
    const auto back = step(COMMAND_PUT_BACK, id);
    send(back);
    become_ready();
    EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
    EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
    device.undeploy();
    device.end();
    device.id = "d2";
  }
}

TEST_F(AgentUpdate, RejectsAnInvalidDescriptorWithItsLine) {
  start_running();
  EXPECT_FALSE(accepts(with("<period>1000000</period><priority>2", "<period>1m</period><priority>2")));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.data()[0]["where"], "new.xml:6");
  EXPECT_FALSE(accepts(with("<cell name=\"cell\"", "<cell name=\"other\"")));
  EXPECT_THAT(device.text(), HasSubstr("a running cell cannot change its name"));
  device.work.inspected = Problems{fail("there is no file arm2.so")};
  EXPECT_FALSE(accepts(kFile));
  EXPECT_THAT(device.text(), HasSubstr("no file arm2.so"));
  EXPECT_EQ(send(step(COMMAND_CHANGE))->code(), REPLY_REFUSED);
  EXPECT_THAT(device.work.swaps, IsEmpty());
  EXPECT_FALSE(device.work.stop_called);
}

TEST_F(AgentUpdate, IsRejectedUnlessTheGivenDeploymentIsRunning) {
  device.become_ready();
  EXPECT_FALSE(accepts(kFile));
  EXPECT_THAT(device.text(), HasSubstr("it is already preparing cell cell"));
  device.run();
  wire::WholeCommand other = step(COMMAND_PREPARE);
  other.head.deployment("d2");
  other.data = kFile;
  EXPECT_EQ(send(other)->code(), REPLY_REFUSED);
}

TEST_F(AgentUpdate, RejectsASecondUpdateAtTheSameTime) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  EXPECT_FALSE(accepts(kFile, "u2"));
  EXPECT_THAT(device.text(), HasSubstr("another operator is updating it"));
  EXPECT_EQ(send(step(COMMAND_CHANGE, "u2"))->code(), REPLY_REFUSED);
  EXPECT_EQ(send_t0("u2")->code(), REPLY_REFUSED);
  EXPECT_EQ(send(step(COMMAND_PUT_BACK, "u2"))->code(), REPLY_OK) << "there is nothing to undo";
  wire::WholeCommand swap = device.command(COMMAND_SWAP);
  swap.head.module_name("arm");
  EXPECT_EQ(send(swap)->code(), REPLY_REFUSED);
  EXPECT_EQ(send_t0()->code(), REPLY_REFUSED) << "the update is not carried out yet";
  EXPECT_EQ(send(step(COMMAND_PUT_BACK))->code(), REPLY_OK);
  EXPECT_TRUE(accepts(kFile, "u3"));
}

TEST_F(AgentUpdate, IsUndoneWhenTheClientStopsSendingKeepAlives) {
  for (const bool changed : {false, true}) {
    const std::string id = changed ? "u2" : "u1";
    if (!changed) start_running();
    ASSERT_TRUE(accepts(kFile, id));
    if (changed) {
      send(step(COMMAND_CHANGE, id));
      done();
    }
    for (int i = 0; i < 5; ++i) {
      device.pass(transaction::kOperatorSilent - seconds{1});
      EXPECT_EQ(device.status().text(), "the update is undone in 1 s, unless takt deploy is heard again");
      send(step(COMMAND_REPORT));
    }
    EXPECT_EQ(device.status().text(), "the update is in progress");
    EXPECT_EQ(device.status().stage(), STAGE_PREPARED) << "the report commands show that the client is alive";
    device.pass(transaction::kOperatorSilent + milliseconds{1});
    EXPECT_EQ(device.status().transaction(), id);
    EXPECT_EQ(device.status().stage(), STAGE_UNDONE) << "so that the other devices undo it too";
    EXPECT_EQ(send(step(COMMAND_CHANGE, id))->code(), REPLY_REFUSED);
    EXPECT_EQ(send_t0(id)->code(), REPLY_REFUSED);
    EXPECT_EQ(file_->kept()->current->text, FakeDevice::kCell);
  }
}

TEST_F(AgentUpdate, IsKeptWithoutTheClientOnceAnotherDeviceHasT0) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  EXPECT_EQ(device.status().transaction(), "u1");
  send(step(COMMAND_CHANGE));
  device.t0_wall = device.wall() + 500'000'000;
  others_say(STAGE_ARMED);
  EXPECT_EQ(device.status().stage(), STAGE_PREPARED) << "it has not made its changes";
  done();
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_ARMED);
  device.pass(milliseconds{500});
  others_say(STAGE_RUNNING);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
  EXPECT_EQ(file_->kept()->current->text, kFile);
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(send(back)->code(), REPLY_REFUSED);
  EXPECT_EQ(answer_to(back)->value(), wire::kKept);
}

TEST_F(AgentUpdate, IsUndoneIfAnotherDeviceDoesNotConfirmT0) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  EXPECT_EQ(send_t0()->code(), REPLY_OK);
  others_say(STAGE_PREPARED);
  device.pass(milliseconds{500});
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  EXPECT_THAT(device.work.swaps.back(), testing::Pair(1U, "/arm.so"));
  done();
  EXPECT_THAT(device.logged.back(), HasSubstr("is not updated: line was not heard to be ready before T0"));
}

TEST_F(AgentUpdate, IsUndoneIfAnotherDeviceUndoesIt) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  others_say(STAGE_UNDONE);
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  EXPECT_THAT(device.work.swaps, IsEmpty());
  EXPECT_EQ(send(step(COMMAND_PUT_BACK))->text(), "") << "the other device says why";
}

TEST_F(AgentUpdate, IsMadeAgainIfAnotherDeviceIsFinal) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  lose_line_after_t0();
  done();
  EXPECT_EQ(file_->kept()->pending->text, kFile);
  others_say(STAGE_FINAL);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
  EXPECT_TRUE(device.work.stop_called);
  end_device();
  EXPECT_EQ(device.work.inspections.back().text, kFile);
  EXPECT_EQ(file_->kept()->current->text, kFile);
  EXPECT_FALSE(file_->kept()->pending);
  device.agent.step();
  const auto t0 = device.work.t0;
  device.work.t0.reset();
  become_ready();
  EXPECT_EQ(device.work.t0, t0) << "it keeps the grid";
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
}

TEST_F(AgentUpdate, IsMadeAgainAfterARestartOfTheNode) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  send_t0();
  FakeDevice again{file_};
  again.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}};
  again.resume();
  EXPECT_EQ(again.work.inspections.back().text, FakeDevice::kCell);
  again.agent.step();
  again.work.phase = Phase::ready;
  again.agent.step();
  EXPECT_EQ(again.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(again.status().transaction(), "u1");
  EXPECT_EQ(again.status().stage(), STAGE_UNDONE);
  DeviceStatus line = again.of_line(DEVICE_RUNNING);
  wire::set(line.transaction(), "u1");
  again.agent.receive(line, FakeDevice::kLine, again.now);
  again.agent.step();
  EXPECT_TRUE(again.work.stop_called);
  again.end();
  EXPECT_EQ(again.work.inspections.back().text, kFile);
  EXPECT_EQ(file_->kept()->current->text, kFile);
}

TEST_F(AgentUpdate, DoesNotStartADeviceAgainThatHasFailed) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  lose_line_after_t0();
  done();
  device.work.failures = {fail("arm crashed")};
  end_device();
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
  others_say(STAGE_FINAL);
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
  EXPECT_EQ(file_->kept()->current->text, kFile) << "the next start of the node restores it";
}

TEST_F(AgentUpdate, RemovesADeviceThatHadUndoneItsRemovalIfAnotherDeviceIsFinal) {
  start_running();
  ASSERT_TRUE(accepts(with("name=\"robot\"", "name=\"other\"")));
  send(step(COMMAND_CHANGE));
  end_device();
  lose_line_after_t0();
  become_ready();
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  others_say(STAGE_FINAL);
  end_device();
  device.agent.step();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_TRUE(file_->kept()->empty());
}

TEST_F(AgentUpdate, AnUndeploymentWinsOverAnUndoneUpdate) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  lose_line_after_t0();
  done();
  device.undeploy();
  end_device();
  others_say(STAGE_FINAL);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().undeployed(), "d1");
  EXPECT_TRUE(file_->kept()->empty());
}

TEST_F(AgentUpdate, IsRejectedWhileAnotherDeviceHasNotHeardThatAllRun) {
  start_running();
  DeviceStatus line = device.of_line(DEVICE_STARTED);
  device.agent.others().receive(line, FakeDevice::kLine);
  EXPECT_FALSE(accepts(kFile));
  EXPECT_THAT(device.text(),
              HasSubstr("device line has not decided about the last deployment or update yet"));
  device.hear_line(DEVICE_RUNNING);
  EXPECT_TRUE(accepts(kFile, "u2"));
}

TEST_F(AgentUpdate, RejectsDamagedData) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  auto change = step(COMMAND_CHANGE);
  for (const char* data : {"", "[]", R"({"devices": [1], "safe": []})", R"({"devices": []})"}) {
    change.data = data;
    change.head.id(std::string{"damaged "} + data);
    EXPECT_EQ(send(change)->code(), REPLY_REFUSED) << data;
  }
  EXPECT_THAT(device.work.swaps, IsEmpty());
}

TEST_F(AgentUpdate, StillReportsTheUpdateAsFinalAfterTheNodeRestarts) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  send(step(COMMAND_CHANGE));
  done();
  keep();
  FakeDevice again{file_};
  again.resume();
  EXPECT_EQ(again.status().transaction(), "u1");
  EXPECT_EQ(again.status().stage(), STAGE_FINAL);
}

TEST_F(AgentUpdate, FinishesTheCurrentStepBeforeItIsUndone) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(send(back), nullptr);
  done();
  EXPECT_THAT(device.work.swaps, ElementsAre(testing::_, std::pair{1U, std::string{"/arm.so"}}));
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
}

TEST_F(AgentUpdate, FailsWhenTheCellIsUndeployedOrTheNodeEnds) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  device.undeploy();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_EQ(answer_to(change)->value(), wire::kUndeployed);
  EXPECT_EQ(send_t0()->value(), wire::kUndeployed);
  done();  // the swap completes only after the cell was undeployed
  end_device();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);

  device.id = "d2";
  start_running();
  ASSERT_TRUE(accepts(kPeriod, "u2"));
  const auto anew = step(COMMAND_CHANGE, "u2");
  send(anew);
  device.agent.end(false);
  EXPECT_EQ(answer_to(anew)->code(), REPLY_FAILED);
  end_device();
  EXPECT_EQ(device.work.supervised, 1) << "the node does not start the new deployment";
  EXPECT_TRUE(device.agent.ended());
}

TEST_F(AgentUpdate, FailsIfTheDeploymentEndsDuringTheUpdate) {
  start_running();
  ASSERT_TRUE(accepts(kFile));
  const auto change = step(COMMAND_CHANGE);
  send(change);
  device.work.failures = {fail("arm crashed")};
  end_device();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_THAT(answer_to(change)->text().to_string(), HasSubstr("arm crashed"));
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
}

}  // namespace
}  // namespace takt::agent::agent_update_test
