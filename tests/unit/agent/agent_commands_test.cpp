#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include <takt/wire/words.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_commands_test {
namespace {

using testing::HasSubstr;

TEST(AgentOnCommand, InspectsComponentsOnceForSeveralDescribeCommands) {
  FakeDevice device;
  device.become_running();
  device.work.inspected.reset();
  device.receive(device.command(COMMAND_DESCRIBE));
  device.receive(device.command(COMMAND_DESCRIBE));
  EXPECT_TRUE(device.published.replies.empty());
  device.work.inspected = Inspected{.paths = {"", ""}, .description = R"({"device":"robot"})"};
  device.agent.step();
  device.receive(device.command(COMMAND_DESCRIBE));
  ASSERT_EQ(device.published.replies.size(), 3U);
  for (const wire::WholeReply& reply : device.published.replies)
    EXPECT_EQ(reply.data, R"({"device":"robot"})");
  EXPECT_EQ(device.work.inspections.size(), 2U);
  EXPECT_TRUE(device.work.inspections[1].describe);
}

TEST(AgentOnCommand, ReturnsTheDeployedDescriptor) {
  FakeDevice device;
  device.receive(device.command(COMMAND_DESCRIPTOR));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "device robot has no deployment");
  device.become_running();
  device.receive(device.command(COMMAND_DESCRIPTOR));
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.published.replies.back().data, FakeDevice::kCell);
  EXPECT_EQ(device.reply().value().to_string(), "cell.xml");
}

TEST(AgentOnCommand, ForwardsACommandToItsModuleAndReturnsTheOutcome) {
  FakeDevice device;
  device.become_running();
  wire::WholeCommand stop = device.command(COMMAND_STOP);
  stop.head.module_name("arm");
  device.receive(stop);
  EXPECT_TRUE(device.published.replies.empty());
  ASSERT_EQ(device.work.commands.size(), 1U);
  EXPECT_EQ(device.work.commands[0], (std::pair{1U, Verb::stop}));
  device.work.done[0]({.code = REPLY_OK, .state = lifecycle::State::start, .text = {}});
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.reply().state(), STATE_START);
  EXPECT_EQ(device.reply().module_name(), "arm");
}

TEST(AgentOnCommand, NamesTheModuleInTheReplyToAFailedCommand) {
  FakeDevice device;
  device.become_running();
  wire::WholeCommand start = device.command(COMMAND_START);
  start.head.module_name("arm");
  device.receive(start);
  ASSERT_EQ(device.work.done.size(), 1U);
  device.work.done[0](
      {.code = REPLY_FAILED, .state = lifecycle::State::recover, .text = "it went to RECOVER"});
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_EQ(device.data()[0]["where"], "module robot.arm");
  EXPECT_EQ(device.data()[0]["what"], "it went to RECOVER");
}

TEST(AgentOnCommand, SuggestsASimilarModuleForAnUnknownName) {
  FakeDevice device;
  device.become_running();
  wire::WholeCommand stop = device.command(COMMAND_STOP);
  stop.head.module_name("serv");
  device.receive(stop);
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("no module 'serv'"));
  EXPECT_THAT(device.text(), HasSubstr("servo"));
}

TEST(AgentOnCommand, ReadsAndSetsAPropertyOfAModule) {
  FakeDevice device;
  device.become_running();
  wire::WholeCommand get = device.command(COMMAND_GET);
  get.head.module_name("arm");
  get.head.property("gain");
  device.receive(get);
  wire::WholeCommand set = device.command(COMMAND_SET);
  set.head.module_name("arm");
  set.head.property("gain");
  set.head.value("2.5");
  device.receive(set);
  EXPECT_EQ(device.work.properties, (std::vector<std::string>{"1 gain", "1 gain = 2.5"}));

  device.work.done[0]({.code = REPLY_OK, .state = lifecycle::State::executing, .text = "", .value = "1.5"});
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.reply().id(), get.head.id());
  EXPECT_EQ(device.reply().value(), "1.5");
  EXPECT_EQ(device.reply().state(), STATE_EXECUTING);
  device.work.done[1]({.code = REPLY_REFUSED, .state = lifecycle::State::executing, .text = "0 to 2"});
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.reply().id(), set.head.id());
  EXPECT_EQ(device.text(), "0 to 2");
}

TEST(AgentOnCommand, RejectsAPropertyOfAnUnknownModule) {
  FakeDevice device;
  wire::WholeCommand get = device.command(COMMAND_GET);
  get.head.module_name("arn");
  get.head.property("gain");
  device.receive(get);
  EXPECT_EQ(device.text(), "device robot has no deployment; deploy a cell to it first: takt deploy CELL");
  device.become_running();
  wire::WholeCommand again = device.command(COMMAND_GET);
  again.head.module_name("arn");
  device.receive(again);
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "device robot has no module 'arn'; did you mean arm?");
  wire::WholeCommand none = device.command(COMMAND_SET);
  device.receive(none);
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << "a device as a whole has no properties";
  EXPECT_TRUE(device.work.properties.empty());
}

TEST(AgentOnCommand, TracesADeploymentForTheRequestedTime) {
  FakeDevice device;
  const auto ask = [&device](const char* value) {
    wire::WholeCommand trace = device.command(COMMAND_TRACE);
    trace.head.value(value);
    device.receive(trace);
    return device.reply().code();
  };
  EXPECT_EQ(ask("5000000000"), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "device robot has no deployment to trace");
  device.become_running();
  for (const char* value : {"", "0", "-1", "5s", "99999999999999999999"}) {
    EXPECT_EQ(ask(value), REPLY_REFUSED) << value;
    EXPECT_EQ(device.text(), "'" + std::string{value} + "' is not a number of nanoseconds above 0");
  }
  EXPECT_EQ(ask("5000000000"), REPLY_OK);
  EXPECT_EQ(device.published.replies.back().data, "5000000000 of " + std::to_string(wire::kMaxData));
}

wire::WholeCommand swap_of(FakeDevice& device, const char* module, const char* file) {
  wire::WholeCommand swap = device.command(COMMAND_SWAP);
  swap.head.module_name(module);
  swap.head.value(file);
  return swap;
}

TEST(AgentOnCommand, RejectsASwapFileGivenWithAFolder) {
  FakeDevice device;
  device.become_running();
  for (const char* file : {"new/arm2.so", "./arm2.so", "/nowhere/arm2.so"}) {
    device.receive(swap_of(device, "arm", file));
    EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
    EXPECT_THAT(device.text(),
                HasSubstr("file " + std::string{file} + ": it has a path, but device robot searches"));
    EXPECT_THAT(device.text(), HasSubstr("copy the file there, then run takt swap robot.arm arm2.so"));
  }
  EXPECT_EQ(device.work.inspections.size(), 1U) << "only the inspection of the deployment";
}

TEST(AgentOnCommand, NamesTheFileWhenItRejectsASwap) {
  FakeDevice device;
  device.become_running();
  device.work.inspected.reset();
  device.receive(swap_of(device, "arm", "arm2.so"));
  device.work.inspected = Problem{"cell.xml:8", "module arm: it has no property 'slope'", ""};
  device.agent.step();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "file arm2.so: module arm: it has no property 'slope'");
}

TEST(AgentOnCommand, InspectsTheNewFileBeforeASwap) {
  FakeDevice device;
  device.become_running();
  device.work.inspected.reset();
  device.receive(swap_of(device, "arm", "arm2.so"));
  ASSERT_EQ(device.work.inspections.size(), 2U);
  EXPECT_EQ(device.work.inspections[1].only, "arm");
  EXPECT_EQ(device.work.inspections[1].swapped.at("arm"), "arm2.so");
  EXPECT_TRUE(device.work.swaps.empty());

  device.receive(swap_of(device, "servo", "servo.so"));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "device robot is still swapping arm; try again later");

  device.work.inspected = Inspected{.paths = {"/components/arm2.so"}};
  device.agent.step();
  ASSERT_EQ(device.work.swaps.size(), 1U);
  EXPECT_EQ(device.work.swaps[0], (std::pair<std::uint32_t, std::string>{1, "/components/arm2.so"}));
  device.work.done.back()({.code = REPLY_OK, .state = lifecycle::State::executing, .text = "from row 5 on"});
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.reply().value().to_string(), "/components/arm2.so");
  EXPECT_EQ(device.published.faults.back().cause().to_string(), "swap to arm2.so was carried out");

  device.receive(device.command(COMMAND_DESCRIBE));
  EXPECT_EQ(device.work.inspections.back().swapped.at("arm"), "/components/arm2.so");
  EXPECT_EQ(device.work.inspections.back().only, "");
}

TEST(AgentOnCommand, RejectsAnImpossibleSwapWithTheReason) {
  FakeDevice device;
  device.receive(swap_of(device, "arm", "arm.so"));
  EXPECT_EQ(device.text(), "device robot has no deployment; deploy a cell to it first: takt deploy CELL");
  device.become_running();
  device.receive(swap_of(device, "arn", "arm.so"));
  EXPECT_EQ(device.text(), "device robot has no module 'arn'; did you mean arm?");
  device.work.may_swap = fail("it is in START", "start it");
  device.receive(swap_of(device, "arm", "arm.so"));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "it is in START; start it");
  EXPECT_EQ(device.work.inspections.size(), 1U) << "no file was inspected";

  device.work.may_swap = {};
  device.work.inspected = Result<Inspected>{fail("there is no file arm3.so", "build it")};
  device.receive(swap_of(device, "arm", "arm3.so"));
  EXPECT_EQ(device.text(), "file arm3.so: there is no file arm3.so; build it");
  EXPECT_EQ(device.published.faults.back().kind(), FAULT_REFUSED_COMMAND);

  device.work.inspected.reset();
  device.receive(swap_of(device, "arm", "arm4.so"));
  device.undeploy();
  device.end();
  const auto& replies = device.published.replies;
  EXPECT_TRUE(std::any_of(replies.begin(), replies.end(), [](const auto& one) {
    return one.head.text().to_string() == "the device is stopping";
  }));
  EXPECT_TRUE(device.work.swaps.empty());
}

TEST(AgentOnCommand, AnswersACommandForTheDeviceAfterAllModulesAnswered) {
  FakeDevice device;
  device.become_running();
  device.receive(device.command(COMMAND_STOP));
  ASSERT_EQ(device.work.commands.size(), 2U);
  device.work.done[0]({.code = REPLY_OK, .state = lifecycle::State::start, .text = {}});
  EXPECT_TRUE(device.published.replies.empty());
  device.work.done[1](
      {.code = REPLY_REFUSED, .state = lifecycle::State::idle, .text = "stop is not allowed in state IDLE"});
  ASSERT_EQ(device.published.replies.size(), 1U);
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_EQ(device.data()[0]["module"], "servo");
  EXPECT_EQ(device.data()[0]["state"], "START");
  EXPECT_EQ(device.data()[1]["ok"], false);
  EXPECT_EQ(device.data()[1]["text"], "stop is not allowed in state IDLE");
}

}  // namespace
}  // namespace takt::agent::agent_commands_test
