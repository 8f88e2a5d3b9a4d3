#include "agent.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include <takt/dds/words.hpp>
#include <takt/os/environment.hpp>

#include "fake_device.hpp"

namespace takt::node::agent_update_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using Phase = Supervised::Phase;

/// The text with one part in place of another.
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

  void runs(const std::string& text = FakeDevice::kCell) {
    device.become_running(text);
    for (const std::uint32_t module : {0U, 1U})
      device.work.stepped({.module = module, .transition = {.to = lifecycle::State::executing}});
    device.work.inspected = Inspected{.paths = {"/servo.so", "/arm2.so"}, .description = kDeclares};
  }
  dds::WholeCommand step(CommandKind kind, const std::string& id = "u1") {
    dds::WholeCommand command = device.command(kind);
    command.head.deployment("d1");
    command.head.property(id);
    return command;
  }
  /// The answer to what was asked last, if there is one.
  const Reply* asks(const dds::WholeCommand& command) {
    device.hear(command);
    device.agent.step();
    return answer_to(command);
  }
  const Reply* answer_to(const dds::WholeCommand& command) {
    const Reply* found = nullptr;
    for (const dds::WholeReply& reply : device.said.replies) {
      if (reply.head.id() != command.head.id()) continue;
      EXPECT_EQ(found, nullptr) << "it was answered twice";
      found = &reply.head;
    }
    return found;
  }
  bool compares(const std::string& text, const std::string& id = "u1") {
    dds::WholeCommand command = step(COMMAND_UPDATE, id);
    command.head.value("new.xml");
    command.data = text;
    const Reply* const reply = asks(command);
    return reply != nullptr && reply->code() == REPLY_OK;
  }
  /// What is under way on the device, answered.
  void done(ReplyCode code = REPLY_OK, const std::string& value = "", const std::string& text = "") {
    ASSERT_FALSE(device.work.done.empty());
    const auto one = device.work.done.back();
    device.work.done.pop_back();
    one({.code = code, .state = lifecycle::State::executing, .text = text, .value = value});
    device.agent.step();
  }
  void ended() { device.end(); }
  void becomes_ready() {
    device.work.phase = Phase::ready;
    device.agent.step();
  }

  std::string folder_ = testing::TempDir() + "takt-update-" + std::to_string(os::process_id());
  DeploymentFile file_{folder_, "robot", 7};
  FakeDevice device{file_};
};

TEST_F(AgentUpdate, WhatDoesNotDifferIsHeldAndKeptAndNothingElse) {
  runs();
  ASSERT_TRUE(compares(with("</cell>", "<!-- the same --></cell>")));
  EXPECT_EQ(device.data()["change"], "none");
  EXPECT_EQ(device.data()["words"].size(), 0U);
  EXPECT_EQ(device.data()["modules"].size(), 2U) << "its ports, for the connections of the others";
  EXPECT_EQ(asks(step(COMMAND_CHANGE))->code(), REPLY_OK);
  EXPECT_EQ(asks(step(COMMAND_KEEP))->code(), REPLY_OK);
  EXPECT_THAT((*file_.kept())->text, HasSubstr("the same"));
  EXPECT_FALSE(device.work.told_to_stop);
  EXPECT_EQ(device.work.inspections.size(), 1U);
}

TEST_F(AgentUpdate, AFileIsLookedAtSwappedAndKept) {
  runs();
  ASSERT_TRUE(compares(kFile));
  EXPECT_EQ(device.data()["change"], "in place");
  EXPECT_EQ(device.data()["words"][0], "robot.arm: file: arm.so -> arm2.so");
  EXPECT_THAT(device.work.swaps, IsEmpty());
  const auto change = step(COMMAND_CHANGE);
  EXPECT_EQ(asks(change), nullptr);
  EXPECT_THAT(device.work.swaps, ElementsAre(std::pair{1U, std::string{"/arm2.so"}}));
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  EXPECT_EQ((*file_.kept())->text, FakeDevice::kCell) << "it can still be put back";
  EXPECT_EQ(asks(step(COMMAND_KEEP))->code(), REPLY_OK);
  EXPECT_EQ((*file_.kept())->text, kFile);
  EXPECT_EQ((*file_.kept())->file, "new.xml");
  EXPECT_FALSE(device.work.told_to_stop);
  EXPECT_THAT(device.said.faults.back().cause().to_string(), HasSubstr("update to new.xml was carried out"));
}

TEST_F(AgentUpdate, APropertyIsSetAndPutBackToWhatItWasAndNotToWhatTheDescriptorSaid) {
  runs(kGain1);
  ASSERT_TRUE(compares(kGain2));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  done(REPLY_OK, "1.5");  // somebody had set it
  EXPECT_EQ(device.work.properties.back(), "1 gain = 2");
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(asks(back), nullptr);
  EXPECT_EQ(device.work.properties.back(), "1 gain = 1.5");
  done();
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(answer_to(back)->value(), dds::kAsBefore);
  EXPECT_EQ((*file_.kept())->text, kGain1);
  EXPECT_TRUE(compares(kGain2, "u2")) << "the next one finds the device free";
}

TEST_F(AgentUpdate, AStepThatFailsPutsTheOnesBeforeItBack) {
  runs(kGain1);
  ASSERT_TRUE(compares(with(kArmBefore, "<name>arm</name><filename>arm2.so</filename>", kGain2)));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  done(REPLY_OK, "1");
  done();
  done(REPLY_FAILED, "", "the third is not for me");  // the swap
  EXPECT_EQ(answer_to(change), nullptr);
  EXPECT_EQ(device.work.properties.back(), "1 gain = 1");
  done();
  ASSERT_NE(answer_to(change), nullptr);
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_THAT(answer_to(change)->text().to_string(), HasSubstr("the third is not for me"));
  EXPECT_EQ(answer_to(change)->value(), dds::kAsBefore);
}

TEST_F(AgentUpdate, WhatCouldNotBePutBackIsSaid) {
  runs();
  ASSERT_TRUE(compares(kFile));
  asks(step(COMMAND_CHANGE));
  done();
  const auto back = step(COMMAND_PUT_BACK);
  asks(back);
  done(REPLY_FAILED, "", "restore() refused");
  EXPECT_EQ(answer_to(back)->code(), REPLY_FAILED);
  EXPECT_EQ(answer_to(back)->value(), "");
  EXPECT_THAT(answer_to(back)->text().to_string(), HasSubstr("restore() refused"));
}

TEST_F(AgentUpdate, APropertyThatItsComponentDoesNotDeclareNeedsAFreshDevice) {
  runs(kGain1);
  device.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}, .description = R"({"modules": []})"};
  ASSERT_TRUE(compares(kGain2));
  EXPECT_EQ(device.data()["change"], "anew");
  EXPECT_THAT(device.data()["words"][0].get<std::string>(),
              HasSubstr("module arm reads gain in initialize() alone"));
}

TEST_F(AgentUpdate, OtherPortsInANewFileNeedAFreshDevice) {
  runs();
  device.work.inspected = Inspected{.paths = {"", ""}, .ports = {std::nullopt, std::vector<model::Port>(1)}};
  ASSERT_TRUE(compares(kFile));
  EXPECT_EQ(device.data()["change"], "anew");
  EXPECT_THAT(device.data()["words"][0].get<std::string>(),
              HasSubstr("module arm has other ports in its new file"));
}

TEST_F(AgentUpdate, AModuleThatCannotBeSwappedNowRefusesIt) {
  runs();
  device.work.may_swap = fail("module robot.arm is in START");
  EXPECT_FALSE(compares(kFile));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("is in START"));
}

TEST_F(AgentUpdate, AModuleThatHasNoInstanceToSetAPropertyOfRefusesIt) {
  runs(kGain1);
  device.work.stepped({.module = 1, .transition = {.to = lifecycle::State::destruct}});
  EXPECT_FALSE(compares(kGain2));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("module robot.arm: it is in DESTRUCT"));
}

TEST_F(AgentUpdate, AnythingElseTakesTheDeviceDownAndUpOnTheSameGrid) {
  runs();
  const auto t0 = device.work.t0;
  device.now += seconds{100};
  ASSERT_TRUE(compares(kPeriod));
  EXPECT_EQ(device.data()["words"][0], "robot is brought up anew: module arm: period: 1 ms -> 2 ms");
  EXPECT_FALSE(device.work.told_to_stop);
  const auto change = step(COMMAND_CHANGE);
  EXPECT_EQ(asks(change), nullptr);
  EXPECT_TRUE(device.work.told_to_stop);
  device.work.t0.reset();
  ended();
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  EXPECT_EQ(device.status().deployment(), "d1") << "to the others it is the same deployment";
  EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{2});
  EXPECT_EQ(device.work.inspections.size(), 2U) << "it was looked at before it was taken down";
  becomes_ready();
  EXPECT_EQ(device.work.t0, t0);
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  EXPECT_EQ((*file_.kept())->text, FakeDevice::kCell);
  asks(step(COMMAND_KEEP));
  EXPECT_EQ((*file_.kept())->text, kPeriod);
}

TEST_F(AgentUpdate, WhatDoesNotComeUpIsPutBackOnTheSameGrid) {
  runs();
  const auto t0 = device.work.t0;
  ASSERT_TRUE(compares(kPeriod));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  ended();
  device.work.failures = {fail("servo cannot be initialised")};
  ended();
  device.work.failures.clear();
  EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{1});
  device.work.t0.reset();
  becomes_ready();
  EXPECT_EQ(device.work.t0, t0);
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_THAT(answer_to(change)->text().to_string(), HasSubstr("servo cannot be initialised"));
  EXPECT_EQ(answer_to(change)->value(), dds::kAsBefore);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ((*file_.kept())->text, FakeDevice::kCell);
}

TEST_F(AgentUpdate, WhereTheOldOneDoesNotComeUpEitherThatIsSaid) {
  runs();
  ASSERT_TRUE(compares(kPeriod));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  ended();
  device.work.failures = {fail("servo cannot be initialised")};
  ended();
  ended();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_EQ(answer_to(change)->value(), "");
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_FAILED);
  EXPECT_EQ((*file_.kept())->text, FakeDevice::kCell) << "--resume tries again";
}

TEST_F(AgentUpdate, ADeviceThatWasBroughtUpAnewIsPutBackWhenAnotherOneFails) {
  runs();
  ASSERT_TRUE(compares(kPeriod));
  asks(step(COMMAND_CHANGE));
  ended();
  becomes_ready();
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(asks(back), nullptr);
  ended();
  EXPECT_EQ(device.work.cell.devices[0].modules[1].period, milliseconds{1});
  becomes_ready();
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
}

TEST_F(AgentUpdate, WhatOperatorsSetAndSwappedStaysWhereTheDescriptorsWordOnItIsTheSame) {
  runs(kGain1);
  dds::WholeCommand set = device.command(COMMAND_SET);
  set.head.module_name("arm");
  set.head.property("gain");
  set.head.value("7");
  asks(set);
  done();
  dds::WholeCommand swap = device.command(COMMAND_SWAP);
  swap.head.module_name("servo");
  swap.head.value("servo9.so");
  device.work.inspected = Inspected{.paths = {"/servo9.so"}};
  asks(swap);
  done();
  device.work.inspected = Inspected{.paths = {"/servo9.so", "/arm.so"}};
  ASSERT_TRUE(
      compares(with("<period>1000000</period><priority>2", "<period>2000000</period><priority>2", kGain1)));
  EXPECT_EQ(device.work.inspections.back().swapped.at("servo"), "/servo9.so");
  asks(step(COMMAND_CHANGE));
  ended();
  EXPECT_EQ(*model::given_property(device.work.cell.devices[0].modules[1], "gain"), "7");
  EXPECT_THAT(device.work.paths, ElementsAre("/servo9.so", "/arm.so"));
  becomes_ready();
  asks(step(COMMAND_KEEP));
  // And where it says something new, that is what counts.
  device.work.inspected = Inspected{.paths = {"", ""}, .description = "{}"};
  ASSERT_TRUE(compares(with("servo.so", "servo1.so", kGain2), "u2"));
  EXPECT_THAT(device.work.inspections.back().swapped, IsEmpty());
  asks(step(COMMAND_CHANGE, "u2"));
  ended();
  EXPECT_EQ(*model::given_property(device.work.cell.devices[0].modules[1], "gain"), "2");
}

TEST_F(AgentUpdate, ANewDeviceTakesUpItsPartOnTheGridOfTheOthers) {
  device.work.inspected = Inspected{.paths = {"", ""}};
  ASSERT_TRUE(compares(FakeDevice::kCell));
  EXPECT_EQ(device.data()["change"], "added");
  EXPECT_FALSE(device.data().contains("t0_ns")) << "it has none";
  auto change = step(COMMAND_CHANGE);
  change.head.time_ns(device.wall() - 10'000'000'000);
  EXPECT_EQ(asks(change), nullptr);
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  becomes_ready();
  EXPECT_EQ(device.work.t0, device.now - seconds{10});
  EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
  EXPECT_FALSE(file_.kept()->has_value());
  asks(step(COMMAND_KEEP));
  EXPECT_EQ((*file_.kept())->id, "d1");
}

TEST_F(AgentUpdate, ANewDeviceIsPutBackToNothing) {
  device.work.inspected = Inspected{.paths = {"", ""}};
  ASSERT_TRUE(compares(FakeDevice::kCell));
  auto change = step(COMMAND_CHANGE);
  change.head.time_ns(device.wall());
  asks(change);
  becomes_ready();
  const auto back = step(COMMAND_PUT_BACK);
  asks(back);
  ended();
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
}

TEST_F(AgentUpdate, ADeviceThatTheCellDoesNotHaveAnyMoreIsTakenDownAndCanBePutBack) {
  for (const bool kept : {false, true}) {
    FakeDevice fresh{file_};
    runs();
    const std::string id = kept ? "u2" : "u1";
    ASSERT_TRUE(compares(with("name=\"robot\"", "name=\"other\""), id));
    EXPECT_EQ(device.data()["change"], "removed");
    const auto change = step(COMMAND_CHANGE, id);
    asks(change);
    ended();
    EXPECT_EQ(answer_to(change)->code(), REPLY_OK);
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_TRUE(file_.kept()->has_value());
    if (kept) {
      asks(step(COMMAND_KEEP, id));
      EXPECT_FALSE(file_.kept()->has_value());
      break;
    }
    const auto back = step(COMMAND_PUT_BACK, id);
    asks(back);
    becomes_ready();
    EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
    EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
    device.undeploy();
    device.end();
  }
}

TEST_F(AgentUpdate, AMistakeChangesNothingAndComesWithItsLine) {
  runs();
  EXPECT_FALSE(compares(with("<period>1000000</period><priority>2", "<period>1ms</period><priority>2")));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.data()[0]["where"], "new.xml:6");
  EXPECT_FALSE(compares(with("<cell name=\"cell\"", "<cell name=\"other\"")));
  EXPECT_THAT(device.text(), HasSubstr("cannot be given another name"));
  device.work.inspected = Problems{fail("there is no file arm2.so")};
  EXPECT_FALSE(compares(kFile));
  EXPECT_THAT(device.text(), HasSubstr("no file arm2.so"));
  EXPECT_EQ(asks(step(COMMAND_CHANGE))->code(), REPLY_REFUSED);
  EXPECT_THAT(device.work.swaps, IsEmpty());
  EXPECT_FALSE(device.work.told_to_stop);
}

TEST_F(AgentUpdate, OnlyARunningDeploymentOfThatIdIsUpdated) {
  device.become_ready();
  EXPECT_FALSE(compares(kFile));
  EXPECT_THAT(device.text(), HasSubstr("it does not run: it is ready"));
  device.run();
  dds::WholeCommand other = step(COMMAND_UPDATE);
  other.head.deployment("d2");
  other.data = kFile;
  EXPECT_EQ(asks(other)->code(), REPLY_REFUSED);
}

TEST_F(AgentUpdate, AnotherOperatorIsRefusedMeanwhile) {
  runs();
  ASSERT_TRUE(compares(kFile));
  EXPECT_FALSE(compares(kFile, "u2"));
  EXPECT_THAT(device.text(), HasSubstr("somebody else is just updating it"));
  EXPECT_EQ(asks(step(COMMAND_CHANGE, "u2"))->code(), REPLY_REFUSED);
  EXPECT_EQ(asks(step(COMMAND_KEEP, "u2"))->code(), REPLY_REFUSED);
  EXPECT_EQ(asks(step(COMMAND_PUT_BACK, "u2"))->code(), REPLY_OK) << "nothing of it is there";
  dds::WholeCommand swap = device.command(COMMAND_SWAP);
  swap.head.module_name("arm");
  EXPECT_EQ(asks(swap)->code(), REPLY_REFUSED);
  EXPECT_EQ(asks(step(COMMAND_KEEP))->code(), REPLY_REFUSED) << "it is not carried out yet";
  EXPECT_EQ(asks(step(COMMAND_PUT_BACK))->code(), REPLY_OK);
  EXPECT_TRUE(compares(kFile, "u3"));
}

TEST_F(AgentUpdate, WhoIsNotHeardOfAnyMoreHasGivenItUp) {
  runs();
  ASSERT_TRUE(compares(kFile));
  asks(step(COMMAND_CHANGE));
  done();
  for (int i = 0; i < 5; ++i) {
    device.pass(seconds{15});
    asks(step(COMMAND_REPORT));
  }
  EXPECT_THAT(device.work.swaps, testing::SizeIs(1)) << "who asks is there";
  device.pass(seconds{15});
  device.pass(seconds{15});
  EXPECT_THAT(device.work.swaps, ElementsAre(testing::_, std::pair{1U, std::string{"/arm.so"}}));
  done();
  EXPECT_EQ(asks(step(COMMAND_KEEP))->code(), REPLY_REFUSED);
  EXPECT_EQ((*file_.kept())->text, FakeDevice::kCell);
}

TEST_F(AgentUpdate, PuttingBackWaitsForTheStepThatIsUnderWay) {
  runs();
  ASSERT_TRUE(compares(kFile));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  const auto back = step(COMMAND_PUT_BACK);
  EXPECT_EQ(asks(back), nullptr);
  done();
  EXPECT_THAT(device.work.swaps, ElementsAre(testing::_, std::pair{1U, std::string{"/arm.so"}}));
  done();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_EQ(answer_to(back)->code(), REPLY_OK);
}

TEST_F(AgentUpdate, EndsWithItsDeploymentAndWithItsNode) {
  runs();
  ASSERT_TRUE(compares(kFile));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  device.undeploy();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  done();  // too late
  ended();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);

  runs();
  ASSERT_TRUE(compares(kPeriod, "u2"));
  const auto anew = step(COMMAND_CHANGE, "u2");
  asks(anew);
  device.agent.end(false);
  EXPECT_EQ(answer_to(anew)->code(), REPLY_FAILED);
  ended();
  EXPECT_EQ(device.work.supervised, 1) << "it is not brought up again";
  EXPECT_TRUE(device.agent.ended());
}

TEST_F(AgentUpdate, ADeploymentThatEndsByItselfTakesItsUpdateAlong) {
  runs();
  ASSERT_TRUE(compares(kFile));
  const auto change = step(COMMAND_CHANGE);
  asks(change);
  device.work.failures = {fail("arm crashed")};
  ended();
  EXPECT_EQ(answer_to(change)->code(), REPLY_FAILED);
  EXPECT_THAT(answer_to(change)->text().to_string(), HasSubstr("arm crashed"));
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
}

}  // namespace
}  // namespace takt::node::agent_update_test
