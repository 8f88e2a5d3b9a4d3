#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include <limits>

#include <takt/wire/words.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;
using Phase = Supervised::Phase;

TEST(Agent, PublishesThatItWaitsForADeployment) {
  FakeDevice device;
  ASSERT_EQ(device.published.devices.size(), 1U);
  EXPECT_EQ(device.status().path(), "-/robot");
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().node(), "here");
  device.pass(seconds{1});
  EXPECT_EQ(device.published.devices.size(), 1U) << "nothing has changed";
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.data()["modules"].size(), 0U);
}

TEST(Agent, RejectsCommandsThatNeedADeployment) {
  FakeDevice device;
  for (const CommandKind kind : {COMMAND_CHANGE, COMMAND_RUN, COMMAND_DESCRIBE, COMMAND_START, COMMAND_STOP,
                                 COMMAND_RECOVER, COMMAND_RESET, COMMAND_DESTRUCT, COMMAND_INITIALIZE}) {
    device.receive(device.command(kind));
    EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << to_text(kind);
    EXPECT_THAT(device.text(), HasSubstr("robot")) << to_text(kind);
  }
  device.receive(device.command(static_cast<CommandKind>(77)));
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("77"));
  device.undeploy();
  EXPECT_EQ(device.reply().code(), REPLY_OK) << "there is nothing to undeploy, as requested";
}

TEST(Agent, RejectsACommandAfterItsDeadline) {
  FakeDevice device;
  wire::WholeCommand late = device.command(COMMAND_PREPARE);
  late.head.deployment("d1");
  late.head.property("d1");
  late.data = FakeDevice::kCell;
  late.head.deadline_ns(device.wall() - 20'000'000);
  device.receive(late);
  EXPECT_EQ(device.reply().code(), REPLY_LATE);
  EXPECT_THAT(device.text(), HasSubstr("20 ms after its deadline"));
  EXPECT_TRUE(device.work.inspections.empty());
  late.head.deadline_ns(0);  // 0 means no deadline
  device.receive(late);
  EXPECT_EQ(device.work.inspections.size(), 1U);
}

TEST(Agent, AnswersAReadOnlyCommandEvenAfterItsDeadline) {
  FakeDevice device;
  device.become_running();
  for (const CommandKind kind : {COMMAND_REPORT, COMMAND_DESCRIBE, COMMAND_GET, COMMAND_TAP, COMMAND_LOG,
                                 COMMAND_TRACE, COMMAND_ALARMS}) {
    wire::WholeCommand late = device.command(kind);
    late.head.module_name("servo");
    late.head.value("1");
    late.head.deadline_ns(device.wall() - 3'600'000'000'000);
    device.receive(late);
    for (const wire::WholeReply& reply : device.published.replies)
      EXPECT_NE(reply.head.code(), REPLY_LATE) << to_text(kind);
  }
}

TEST(Agent, RejectsExtremeTimesInCommandsWithoutOverflow) {
  constexpr std::int64_t kMin = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  FakeDevice device;
  device.become_ready();
  for (const std::int64_t time : {kMin, std::int64_t{-1}, std::int64_t{1}, kMax}) {
    wire::WholeCommand run = device.command(COMMAND_RUN);
    run.head.time_ns(time);
    device.receive(run);
    EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << time;
    wire::WholeCommand undeploy = device.command(COMMAND_UNDEPLOY);
    undeploy.head.deployment("another");
    undeploy.head.deadline_ns(time);
    device.receive(undeploy);
    EXPECT_EQ(device.reply().code(), time == kMax ? REPLY_OK : REPLY_LATE) << time;
  }
  device.run();
  device.start_with_line();
  for (const std::int64_t time : {kMin, std::int64_t{0}, kMax}) {
    wire::WholeCommand tap = device.command(COMMAND_TAP);
    tap.head.module_name("servo");
    tap.head.time_ns(time);
    device.receive(tap);
    EXPECT_EQ(device.reply().code(), REPLY_OK) << time;
  }
}

TEST(Agent, LimitsAForceToOneHourAndNamesTheOperator) {
  FakeDevice device;
  device.become_running();
  wire::WholeCommand force = device.command(COMMAND_FORCE);
  force.head.id("client-1");
  force.head.module_name("servo");
  force.head.property("setpoint");
  force.head.value("bert on desk");
  force.head.time_ns(Nanoseconds{std::chrono::hours{1}}.count());
  force.data = R"({"value": 1})";
  device.receive(force);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  force.head.id("client-2");
  force.who = "operator anna at 10.0.0.7";
  device.receive(force);
  ASSERT_EQ(device.work.forces.size(), 2U);
  EXPECT_EQ(device.work.forces[0].second.by, "bert on desk");
  EXPECT_EQ(device.work.forces[0].second.data, force.data);
  EXPECT_EQ(device.work.forces[1].second.by, "operator anna at 10.0.0.7") << "not what the client says";
  EXPECT_EQ(device.work.forces[1].second.client, device.work.forces[0].second.client);
  EXPECT_EQ(device.work.forces[1].second.duration, std::chrono::hours{1});

  for (const std::int64_t time : {std::int64_t{0}, std::int64_t{-1}, force.head.time_ns() + 1,
                                  std::numeric_limits<std::int64_t>::min()}) {
    force.head.id("client-3" + std::to_string(time));
    force.head.time_ns(time);
    device.receive(force);
    EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << time;
    EXPECT_THAT(device.reply().text().to_string(), HasSubstr("at most 3600 s"));
  }
  wire::WholeCommand end = device.command(COMMAND_END_FORCE);
  end.head.module_name("servo");
  end.head.property("setpoint");
  end.head.value("eve");
  device.receive(end);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_THAT(device.work.ended_forces, testing::ElementsAre("0 setpoint by eve"));
}

TEST(Agent, PassesOnHowOftenAnObserverWantsTheNewestSample) {
  FakeDevice device;
  device.become_running();
  wire::WholeCommand tap = device.command(COMMAND_TAP);
  tap.head.module_name("servo");
  tap.head.value("500000000");
  device.receive(tap);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.work.tapped_every, std::chrono::milliseconds{500});
  for (const char* wrong : {"-1", "1 s", "99999999999999999999"}) {
    tap = device.command(COMMAND_TAP);
    tap.head.module_name("servo");
    tap.head.value(wrong);
    device.receive(tap);
    EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << wrong;
  }
  tap = device.command(COMMAND_TAP);
  tap.head.module_name("servo");
  device.receive(tap);
  EXPECT_EQ(device.work.tapped_every, Nanoseconds{0}) << "every sample";
}

TEST(Agent, FailsPendingDescribeCommandsWhenTheDeploymentEnds) {
  FakeDevice device;
  device.become_running();
  device.work.inspected.reset();
  device.receive(device.command(COMMAND_DESCRIBE));
  device.receive(device.command(COMMAND_DESCRIBE));
  EXPECT_TRUE(device.published.replies.empty());
  device.undeploy();
  device.end();
  ASSERT_EQ(device.published.replies.size(), 3U);
  EXPECT_EQ(device.published.replies[0].head.code(), REPLY_FAILED);
  EXPECT_THAT(device.published.replies[0].head.text().to_string(), HasSubstr("before it was described"));
}

TEST(Agent, RunsAPreparedDeploymentOnCommand) {
  FakeDevice device;
  device.prepare();
  EXPECT_TRUE(device.published.replies.empty()) << "the reply comes only when the components are inspected";
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  EXPECT_EQ(device.status().path(), "cell/robot");
  EXPECT_EQ(device.status().modules(), 2U);
  ASSERT_EQ(device.work.inspections.size(), 1U);
  EXPECT_FALSE(device.work.inspections[0].as_written);

  device.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}};
  device.agent.step();
  ASSERT_EQ(device.published.replies.size(), 1U);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.data()["modules"][1]["name"], "arm");
  EXPECT_EQ(device.work.supervised, 0) << "no module is started before all devices have checked the cell";
  device.change();
  EXPECT_EQ(device.work.supervised, 1);
  device.run(milliseconds{300});
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << "the modules are not in START yet";
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  device.published.replies.clear();
  device.become_prepared();
  ASSERT_EQ(device.published.replies.size(), 1U);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_READY);
  EXPECT_FALSE(device.work.t0);

  device.run(milliseconds{300});
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.status().state(), DEVICE_ARMED);
  EXPECT_EQ(device.status().t0_ns(), device.t0_wall);
  EXPECT_FALSE(device.work.t0) << "the other device may not have received T0";
  device.hear_line(DEVICE_ARMED);
  EXPECT_EQ(device.work.t0, device.now + milliseconds{300}) << "on the monotonic clock";
  EXPECT_EQ(device.status().state(), DEVICE_ARMED);
  device.pass(milliseconds{300});
  EXPECT_EQ(device.status().state(), DEVICE_STARTED);
  device.hear_line(DEVICE_STARTED);
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
}

TEST(Agent, PublishesEveryTransitionOfAModuleWithItsSequenceNumber) {
  FakeDevice device;
  device.become_running();
  ASSERT_EQ(device.published.steps.size(), 2U);
  EXPECT_EQ(device.published.steps[0].path(), "cell/robot/servo");
  EXPECT_EQ(device.published.steps[0].event(), EVENT_NONE);
  EXPECT_EQ(device.published.steps[0].sequence_number(), 0U);
  device.work.stepped({.module = 1,
                       .transition = {.from = lifecycle::State::executing,
                                      .to = lifecycle::State::recover,
                                      .event = lifecycle::Event::error,
                                      .sequence = 4},
                       .error = ErrorType::budget,
                       .text = "it took too long"});
  const LifecycleStatus& step = device.published.steps.back();
  EXPECT_EQ(step.path(), "cell/robot/arm");
  EXPECT_EQ(step.previous_state(), STATE_EXECUTING);
  EXPECT_EQ(step.state(), STATE_RECOVER);
  EXPECT_EQ(step.event(), EVENT_ERROR);
  EXPECT_EQ(step.error(), ERROR_BUDGET);
  EXPECT_EQ(step.text(), "it took too long");
  EXPECT_EQ(step.sequence_number(), 4U);
  EXPECT_EQ(step.time_ns(), device.wall());
}

TEST(Agent, PublishesEventsStatesAndErrorsWithTheNamesThatTheLifecycleCodeUses) {
  FakeDevice device;
  device.become_running();
  for (const lifecycle::Event event : lifecycle::kEvents) {
    device.work.stepped({.module = 0, .transition = {.event = event}});
    EXPECT_STREQ(to_text(device.published.steps.back().event()), lifecycle::to_text(event));
  }
  for (const lifecycle::State state : lifecycle::kStates) {
    device.work.stepped({.module = 0, .transition = {.to = state}});
    EXPECT_STREQ(to_text(device.published.steps.back().state()), lifecycle::to_text(state));
  }
  for (int type = 1; type <= 5; ++type) {
    device.work.stepped({.module = 0, .transition = {}, .error = static_cast<ErrorType>(type)});
    EXPECT_STREQ(to_text(device.published.steps.back().error()), to_text(static_cast<ErrorType>(type)));
  }
}

TEST(Agent, RejectsAnInvalidDescriptorAndListsAllProblems) {
  FakeDevice device;
  device.prepare("d1", "<cell name=\"cell\"><device name=\"robot\"><module/></device></cell>");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_GT(device.data().size(), 1U);
  EXPECT_EQ(device.data()[0]["where"], "cell.xml:1");
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_TRUE(device.work.inspections.empty());
}

TEST(Agent, RejectsADescriptorWithoutTheIdOfItsDeployment) {
  FakeDevice device;
  device.prepare("");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device.text(), "device robot: the command is damaged");
}

TEST(Agent, RejectsACellWithoutThisDevice) {
  FakeDevice device;
  std::string text = FakeDevice::kCell;
  text.replace(text.find("robot"), 5, "robot2");
  device.prepare("d1", text);
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("cell cell has no device robot"));
}

TEST(Agent, RejectsACellThatRequiresSecurityIfTheNodeHasNoIdentity) {
  std::string text = FakeDevice::kCell;
  text.replace(text.find(">"), 1, " security=\"required\">");
  FakeDevice without;
  without.prepare("d1", text);
  EXPECT_EQ(without.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(without.text(),
              HasSubstr("cell cell requires security, but the node of device robot runs without"));
  EXPECT_EQ(without.status().state(), DEVICE_WAITING);
  FakeDevice with{{}, false, {}, "cell"};
  with.prepare("d1", text);
  EXPECT_TRUE(with.published.replies.empty());
}

TEST(Agent, RejectsACellForWhichItHasNoIdentity) {
  FakeDevice device{{}, false, {}, "another"};
  device.prepare();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(),
              HasSubstr("the identity of device robot is for cell another, not for cell cell"));
}

TEST(Agent, RejectsADeploymentWithMissingComponents) {
  FakeDevice device;
  device.prepare();
  device.work.inspected =
      Problems{{"cell.xml:3", "no file servo.so", "copy it"}, {"cell.xml:5", "no file arm.so", "copy it"}};
  device.agent.step();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  ASSERT_EQ(device.data().size(), 2U);
  EXPECT_EQ(device.data()[1]["what"], "no file arm.so");
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_TRUE(device.published.withdrawn.empty()) << "no module was published";
}

TEST(Agent, ReportsAFailedStartOfAModuleOnlyAfterEverythingIsUndone) {
  FakeDevice device;
  device.begin();
  device.published.replies.clear();
  device.work.failures = {{"module robot.servo", "initialize() failed: no power", "correct the module"}};
  device.work.phase = Phase::stopping;
  device.agent.step();
  EXPECT_TRUE(device.published.replies.empty());
  device.end();
  ASSERT_EQ(device.published.replies.size(), 1U);
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_EQ(device.data()[0]["where"], "module robot.servo");
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE) << "so that line undoes the deployment too";
  EXPECT_THAT(device.published.withdrawn, ElementsAre("cell/robot/servo", "cell/robot/arm"));
  EXPECT_EQ(device.work.supervised, 0);
  device.undeploy("d1");
  EXPECT_EQ(device.data()["report"]["name"], "robot") << "its final report is still available";
}

TEST(Agent, RejectsADeploymentThatCannotBeSetUp) {
  FakeDevice device;
  device.work.prepared = fail("no shared memory");
  device.begin();
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_EQ(device.text(), "no shared memory");
  EXPECT_EQ(device.work.supervised, 0);
}

TEST(Agent, RejectsASecondDeployment) {
  FakeDevice device;
  device.prepare("d1");
  device.prepare("d2");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("device robot: it is already preparing cell cell"));
  device.work.inspected = Inspected{.paths = {"", ""}};
  device.agent.step();
  device.change();
  device.prepare("d2");
  EXPECT_THAT(device.text(), HasSubstr("device robot: it is already preparing cell cell"));
  device.become_prepared();
  device.run();
  device.start_with_line();
  device.prepare("d2");
  EXPECT_THAT(device.text(), HasSubstr("device robot: it already runs cell cell; undeploy it first"));
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(device.work.inspections.size(), 1U);
}

TEST(Agent, RejectsAStartTimeInThePastOrFarInTheFuture) {
  FakeDevice device;
  device.become_ready();
  device.run(milliseconds{-30});
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("passed 30 ms ago"));
  EXPECT_THAT(device.text(), HasSubstr("synchronise the clocks"));
  device.run(seconds{3600});
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  device.run(milliseconds{100}, "another");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_FALSE(device.work.t0);
}

TEST(Agent, UndoesAPreparedDeploymentThatTheClientNeverStarts) {
  FakeDevice device;
  device.become_ready();
  device.pass(transaction::kOperatorSilent);
  EXPECT_FALSE(device.work.stop_called);
  device.pass(milliseconds{1});
  EXPECT_TRUE(device.work.stop_called);
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_OK);
  device.run();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("it has undone this: no message of the operator arrived within 10 s"));
}

// Expects that the pending command fails for `reason` after 10 s, but not earlier, because the nodes or their
// ports may not have discovered each other yet. Then the deployment is undone.
void expect_undone_after_10_s(FakeDevice& device, const std::string& reason) {
  device.pass(seconds{10});
  EXPECT_TRUE(device.published.replies.empty());
  EXPECT_FALSE(device.work.stop_called);
  device.pass(milliseconds{1});
  EXPECT_TRUE(device.work.stop_called);
  device.end();
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_EQ(device.text(), reason);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
}

TEST(Agent, UndoesADeploymentIfItDoesNotFindAnotherDeviceOfTheCell) {
  FakeDevice device;
  device.begin();
  device.published.replies.clear();
  device.work.phase = Phase::ready;
  device.pass(milliseconds{10});
  expect_undone_after_10_s(device, "it has not found device line; check the network between the two devices");
}

/// The request that the client sends while it waits for a slower device.
wire::WholeCommand keep_alive(FakeDevice& device, const std::string& deployment) {
  wire::WholeCommand c = device.command(COMMAND_REPORT);
  c.head.deployment(deployment);
  return c;
}

constexpr const char* kUnmatched = "robot.arm.out -> line.panel.in";

TEST(Agent, UndoesADeploymentIfAConnectionCannotBeMade) {
  FakeDevice device;
  device.begin();
  device.work.unmatched = kUnmatched;
  device.published.replies.clear();
  device.become_prepared();
  device.hear_line(DEVICE_READY);
  expect_undone_after_10_s(device,
                           "the connection robot.arm.out -> line.panel.in could not be made; check the "
                           "network between the devices");
}

TEST(Agent, WaitsForTheConnectionsToADeviceThatStillPrepares) {
  FakeDevice device;
  device.begin();
  device.work.unmatched = kUnmatched;
  device.published.replies.clear();
  device.work.phase = Phase::ready;
  for (int i = 0; i < 3; ++i) {
    device.hear_line(DEVICE_PREPARING);
    device.pass(seconds{10});
    device.receive(keep_alive(device, "d1"));
  }
  device.published.replies.clear();
  EXPECT_FALSE(device.work.stop_called);
  device.hear_line(DEVICE_READY);
  device.pass(seconds{9});
  EXPECT_TRUE(device.published.replies.empty());
  device.work.unmatched = "";
  device.pass(milliseconds{10});
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  device.run();
  EXPECT_EQ(device.reply().code(), REPLY_OK);
}

TEST(Agent, UndoesADeploymentIfAnotherDeviceIsNotArmedAtT0) {
  FakeDevice device;
  device.become_ready();
  device.run();
  device.hear_line(DEVICE_READY);
  device.pass(milliseconds{499});
  EXPECT_FALSE(device.work.stop_called);
  device.pass(milliseconds{1});
  EXPECT_TRUE(device.work.stop_called);
  EXPECT_FALSE(device.work.t0) << "nothing has run";
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE) << "so that line undoes the deployment too";
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().transaction(), "d1");
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  EXPECT_EQ(device.status().text(), "cell cell was not started: line was not heard to be ready before T0");
  device.prepare("d1");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << "a late command must not prepare it again";
  device.work.inspected.reset();
  device.prepare("d2");
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  EXPECT_EQ(device.status().health(), HEALTH_OK) << "the reason is no longer of interest";
}

TEST(Agent, AcceptsT0FromAnotherDeviceIfTheOperatorIsLost) {
  FakeDevice device;
  device.begin(FakeDevice::kCell, {.paths = {"/servo.so", "/arm.so"}},
               model::safe_json({{{"line", "belt", "state"}, R"({"speed": 0})"}}));
  device.work.unmatched = kUnmatched;
  device.work.phase = Phase::ready;
  device.t0_wall = device.wall() + 500'000'000;
  device.hear_line(DEVICE_ARMED);
  EXPECT_EQ(device.status().state(), DEVICE_READY) << "it is not connected yet";
  device.work.unmatched = "";
  device.agent.step();
  EXPECT_EQ(device.status().state(), DEVICE_ARMED);
  EXPECT_EQ(device.status().t0_ns(), device.t0_wall);
  device.start_with_line();
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(device.work.safe.size(), 1U);
}

TEST(Agent, HearsTheMoreAdvancedOfTwoNodesWithOneName) {
  FakeDevice device;
  device.become_ready();
  device.run(milliseconds{300});
  device.agent.others().receive(device.of_line(DEVICE_READY), FakeDevice::kLine);
  DeviceStatus second = device.of_line(DEVICE_ARMED);
  wire::set(second.node(), "second node of line");
  device.agent.others().receive(second, FakeDevice::kLine + 1);
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_RUNNING);
}

TEST(Agent, UndoesADeploymentThatAnotherDeviceHasUndone) {
  for (const bool armed : {false, true}) {
    FakeDevice device;
    device.become_ready();
    if (armed) device.run();
    DeviceStatus line = device.of_line(DEVICE_WAITING);
    wire::set(line.deployment(), "");
    wire::set(line.transaction(), "d1");
    line.stage(STAGE_UNDONE);
    device.agent.others().receive(line, FakeDevice::kLine);
    device.agent.step();
    EXPECT_TRUE(device.work.stop_called);
    EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
    device.end();
    device.undeploy("d1");
    EXPECT_TRUE(device.data()["failures"].empty()) << "line reports why";
  }
}

TEST(Agent, UndoesTheDeploymentIfTheDeviceFailsBeforeT0) {
  FakeDevice device;
  device.become_ready();
  device.run();
  device.hear_line(DEVICE_ARMED);
  device.pass(milliseconds{300});
  EXPECT_EQ(device.status().stage(), STAGE_RUNNING);
  device.work.failures = {fail("the host has crashed")};
  device.work.stops_cell = true;
  device.work.phase = Phase::stopping;
  device.agent.step();
  EXPECT_EQ(device.status().stage(), STAGE_UNDONE) << "at once, so that no other device becomes final";
  EXPECT_FALSE(device.status().stops_cell()) << "no module has run yet";
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().text(), "cell cell was not started: the host has crashed");
  device.undeploy("d1");
  EXPECT_EQ(device.data()["failures"].size(), 1U);
}

TEST(Agent, FailsLikeARunningDeviceIfItFailsBetweenT0AndTheDecision) {
  FakeDevice device;
  device.become_ready();
  device.run();
  device.hear_line(DEVICE_ARMED);
  device.pass(milliseconds{500});
  EXPECT_EQ(device.status().state(), DEVICE_STARTED);
  device.work.failures = {fail("arm crashed")};
  device.work.stops_cell = true;
  device.work.phase = Phase::stopping;
  device.agent.step();
  EXPECT_TRUE(device.status().stops_cell());
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
  EXPECT_EQ(device.status().stage(), STAGE_RUNNING) << "line decides as if this device still ran";
  device.hear_line(DEVICE_STARTED);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
}

TEST(Agent, BeginsIfItOnlyHearsThatAnotherDeviceIsFinal) {
  FakeDevice device;
  device.become_ready();
  device.t0_wall = device.wall() - 500'000'000;
  device.hear_line(DEVICE_RUNNING);
  EXPECT_EQ(device.work.t0, device.now - milliseconds{500});
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
}

/// A device that has undone deployment d1, because it lost the other device soon after T0. The other device
/// may have heard that all devices run.
class UndoneDevice : public testing::Test {
 protected:
  UndoneDevice() {
    device.become_ready();
    device.run();
    device.hear_line(DEVICE_ARMED);
    device.pass(milliseconds{500});
    device.agent.others().lost(FakeDevice::kLine);
    device.pass(transaction::kHeardWithin + milliseconds{1});
    device.end();
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
  }
  FakeDevice device;
};

TEST_F(UndoneDevice, HasRecordedWhyTheCellEnded) {
  EXPECT_EQ(device.published.faults.back().cause(),
            "cell cell has ended: line was not heard to run within 3 s of T0");
}

TEST_F(UndoneDevice, BeginsAgainIfAnotherDeviceIsFinal) {
  device.hear_line(DEVICE_STARTED);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  device.hear_line(DEVICE_RUNNING);
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
  EXPECT_EQ(device.status().stage(), STAGE_FINAL);
  EXPECT_EQ(device.status().health(), HEALTH_OK);
  device.pass(milliseconds{10});
  device.work.phase = Phase::ready;
  device.pass(milliseconds{10});
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
  EXPECT_EQ(device.work.t0, device.now + Nanoseconds{device.t0_wall - device.wall()}) << "on the same grid";
}

TEST_F(UndoneDevice, DoesNotBeginAgainOnceItIsUndeployed) {
  device.undeploy("d1");
  EXPECT_EQ(device.status().transaction(), "");
  device.hear_line(DEVICE_RUNNING);
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().undeployed(), "d1") << "so that line ends it too";
}

TEST_F(UndoneDevice, DoesNotBeginAgainAfterAnotherDeployment) {
  device.prepare("d2");
  device.hear_line(DEVICE_RUNNING);
  EXPECT_EQ(device.status().transaction(), "d2");
  EXPECT_EQ(device.status().undeployed(), "d1") << "so that line ends it";
}

TEST_F(UndoneDevice, ForgetsTheDeploymentIfItWasUndeployedOnAnotherDevice) {
  DeviceStatus line = device.of_line(DEVICE_WAITING);
  wire::set(line.deployment(), "");
  wire::set(line.undeployed(), "d1");
  device.agent.others().receive(line, FakeDevice::kLine);
  device.agent.step();
  EXPECT_EQ(device.status().transaction(), "");
}

TEST(Agent, EndsTheDeploymentIfAnotherDeviceDoesNotReportThatItRunsSoonAfterT0) {
  FakeDevice device;
  device.become_ready();
  device.run();
  device.hear_line(DEVICE_ARMED);
  device.pass(milliseconds{500});
  EXPECT_EQ(device.status().state(), DEVICE_STARTED);
  device.agent.others().lost(FakeDevice::kLine);
  device.pass(transaction::kHeardWithin);
  EXPECT_FALSE(device.work.stop_called);
  device.pass(milliseconds{1});
  EXPECT_TRUE(device.work.stop_called);
  device.undeploy("d1");
  device.end();
  EXPECT_EQ(device.data()["failures"][0], "device robot: error: line was not heard to run within 3 s of T0");
  EXPECT_EQ(device.published.faults.back().cause(), "cell cell has ended: it was undeployed");
}

TEST(Agent, UndeploysADeploymentThatAnotherDeviceHasUndeployed) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = device.of_line(DEVICE_WAITING);
  wire::set(line.deployment(), "");
  wire::set(line.undeployed(), "d0");
  device.agent.others().receive(line, FakeDevice::kLine);
  device.agent.step();
  EXPECT_FALSE(device.work.stop_called) << "another deployment was undeployed";
  wire::set(line.undeployed(), "d1");
  wire::set(line.device(), "station");
  wire::set(line.node(), "node of station");
  device.agent.others().receive(line, 78);
  device.agent.step();
  EXPECT_FALSE(device.work.stop_called) << "the station is not a device of the cell";
  wire::set(line.device(), "line");
  device.agent.others().receive(line, FakeDevice::kLine);
  device.agent.step();
  EXPECT_TRUE(device.work.stop_called);
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(device.status().health(), HEALTH_OK) << "an operator wanted this";
  EXPECT_EQ(device.published.faults.back().cause(), "cell cell has ended: it was undeployed")
      << "all devices record the same reason";
  device.undeploy("d1");
  EXPECT_EQ(device.data()["failures"].size(), 0U);
}

// An operator whose deployment was rejected, because the device prepares another one, undoes its own on all
// devices.
TEST(Agent, KeepsItsDeploymentWhenAnotherOneIsUndeployed) {
  FakeDevice device;
  device.prepare();
  device.undeploy("d2");
  EXPECT_EQ(device.reply().code(), REPLY_OK) << "the device does not have deployment d2";
  EXPECT_EQ(device.text(), "device robot has another deployment, of cell cell");
  device.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}};
  device.agent.step();
  device.change();
  device.become_prepared();
  device.undeploy("d3");
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_FALSE(device.work.stop_called);
  EXPECT_EQ(device.status().deployment(), "d1");
  device.undeploy("d1");
  device.end();
  for (const char* const id : {"d2", "d3"}) {
    device.prepare(id);
    EXPECT_EQ(device.text(), "device robot: it has already ended this deployment")
        << "its commands may be late";
  }
}

TEST(Agent, DoesNotReportAFailureIfAnotherDeviceUndeploysBeforeTheStart) {
  FakeDevice device;
  device.become_ready();
  DeviceStatus line = device.of_line(DEVICE_WAITING);
  wire::set(line.undeployed(), "d1");
  device.agent.others().receive(line, FakeDevice::kLine);
  device.agent.step();
  EXPECT_TRUE(device.work.stop_called);
  device.end();
  device.undeploy("d1");
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.data()["failures"].size(), 0U);
}

TEST(Agent, PassesAnUndeploymentOnToADeviceThatComesBack) {
  FakeDevice device;
  device.become_running();
  device.undeploy("d1");
  device.end();
  device.pass(seconds{3600});
  EXPECT_EQ(device.status().undeployed(), "");
  device.hear_line(DEVICE_RUNNING);
  EXPECT_EQ(device.status().undeployed(), "d1");
}

TEST(Agent, KeepsTheCellRunningIfTheClientStopsSendingKeepAlives) {
  FakeDevice device;
  device.become_running();
  device.pass(seconds{100});
  EXPECT_FALSE(device.work.stop_called);
}

TEST(Agent, ReturnsTheFinalReportWhenItUndeploysADevice) {
  FakeDevice device;
  device.become_running();
  device.undeploy("d1");
  EXPECT_TRUE(device.published.replies.empty());
  EXPECT_TRUE(device.work.stop_called);
  EXPECT_EQ(device.status().state(), DEVICE_STOPPING);
  device.work.failures = {{"module robot.arm", "it was given up", ""}};
  device.end();
  ASSERT_EQ(device.published.replies.size(), 1U);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.data()["report"]["name"], "robot");
  EXPECT_EQ(device.data()["failures"][0], "module robot.arm: error: it was given up");
  EXPECT_EQ(device.status().path(), "-/robot");
  EXPECT_EQ(device.published.withdrawn.size(), 2U);
  device.work.inspected.reset();
  device.prepare("d2");
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
}

TEST(Agent, UndeploysDuringAnyStageOfPreparation) {
  for (const bool starting : {false, true}) {
    FakeDevice device;
    if (starting)
      device.begin();
    else
      device.prepare();
    device.published.replies.clear();
    device.undeploy("d1");
    if (starting) device.end();
    ASSERT_EQ(device.published.replies.size(), 2U);
    EXPECT_EQ(device.published.replies[0].head.code(), REPLY_FAILED);
    EXPECT_EQ(device.published.replies[0].head.text(), "device robot: it was undeployed");
    EXPECT_EQ(device.published.replies[1].head.code(), REPLY_OK);
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_EQ(device.status().transaction(), "");
  }
}

/// The reasons why deployments have ended, as in the fault record.
std::vector<std::string> ends(const FakeDevice& device) {
  std::vector<std::string> causes;
  for (const FaultEvent& event : device.published.faults) {
    const std::string cause = event.cause().to_string();
    if (cause.starts_with("cell cell has ended")) causes.push_back(cause);
  }
  return causes;
}

TEST(Agent, KeepsAFailedDeploymentUntilItIsUndeployed) {
  FakeDevice device;
  device.become_running();
  device.work.failures = {{"module robot.arm", "it was given up: it broke", ""}};
  device.work.phase = Phase::stopping;
  device.agent.step();
  device.end();
  EXPECT_EQ(device.status().state(), DEVICE_ENDED);
  EXPECT_EQ(device.status().health(), HEALTH_FAILED);
  EXPECT_THAT(device.status().text().to_string(), HasSubstr("it broke"));
  EXPECT_EQ(device.status().path(), "cell/robot");
  device.prepare("d2");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("it still holds cell cell, which has ended; undeploy it first"));
  device.undeploy();
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_THAT(device.data()["failures"][0], HasSubstr("it broke"));
  EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  EXPECT_EQ(ends(device),
            (std::vector<std::string>{"cell cell has ended: module robot.arm: it was given up: it broke"}));
}

TEST(Agent, RecordsWhyADeploymentHasEndedIfAModuleWasGivenUpBefore) {
  FakeDevice undeployed;
  undeployed.become_running();
  undeployed.work.failures = {{"module robot.arm", "it was given up: it broke", ""}};
  undeployed.undeploy();
  undeployed.end();
  EXPECT_EQ(ends(undeployed), (std::vector<std::string>{"cell cell has ended: it was undeployed"}));
  EXPECT_THAT(undeployed.data()["failures"][0], HasSubstr("it broke"));

  FakeDevice leaving;
  leaving.become_running();
  leaving.work.failures = undeployed.work.failures;
  leaving.agent.end(false);
  leaving.end();
  EXPECT_EQ(ends(leaving), (std::vector<std::string>{"cell cell has ended: its node is shutting down"}));
}

TEST(Agent, IsDegradedWhileAModuleIsFaulty) {
  FakeDevice device;
  device.become_running();
  device.work.standing.faulty = "module arm is in RECOVER";
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_DEGRADED);
  EXPECT_EQ(device.status().text(), "module arm is in RECOVER");
  device.work.standing.faulty.clear();
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_OK);
}

TEST(Agent, PublishesStatisticsOnceASecondDuringADeployment) {
  FakeDevice device;
  device.pass(seconds{5});
  EXPECT_EQ(device.published.measures, 0);
  device.become_running();
  const int before = device.published.measures;
  for (int i = 0; i < 200; ++i) device.pass(milliseconds{50});
  EXPECT_EQ(device.published.measures - before, 10);
}

TEST(Agent, SetsTheSafeValuesOfTheCellBeforeItRuns) {
  FakeDevice device;
  const model::SafeOutput output{{"line", "belt", "state"}, R"({"speed": 0})"};
  device.become_ready(FakeDevice::kCell, {.paths = {"/servo.so", "/arm.so"}}, model::safe_json({output}));
  device.run(milliseconds{1});
  device.hear_line(DEVICE_ARMED);
  EXPECT_TRUE(device.work.t0);
  EXPECT_EQ(device.work.safe, (std::vector<model::SafeOutput>{output}));
}

TEST(Agent, StopsItsDeploymentBeforeTheNodeEnds) {
  FakeDevice device;
  device.become_running();
  device.agent.end(false);
  EXPECT_TRUE(device.work.stop_called);
  device.agent.step();
  EXPECT_FALSE(device.agent.ended());
  device.end();
  EXPECT_TRUE(device.agent.ended());

  FakeDevice waiting;
  waiting.agent.end(false);
  EXPECT_TRUE(waiting.agent.ended());
}

TEST(Agent, WaitsBrieflyUntilTaktRunHasFetchedTheFinalReport) {
  FakeDevice device{{}, true};
  device.become_running();
  EXPECT_TRUE(device.work.inspections[0].as_written);
  device.agent.end(false);
  device.end();
  EXPECT_FALSE(device.agent.ended());
  device.undeploy();
  EXPECT_FALSE(device.agent.ended()) << "the answer may still be on its way";
  device.agent.end(true);
  EXPECT_TRUE(device.agent.ended());

  FakeDevice forgotten{{}, true};
  forgotten.become_running();
  forgotten.agent.end(false);
  forgotten.end();
  forgotten.pass(seconds{3});
  EXPECT_TRUE(forgotten.agent.ended());

  FakeDevice orphan{{}, true};
  orphan.become_running();
  orphan.agent.end(true);
  orphan.end();
  EXPECT_TRUE(orphan.agent.ended());
}

TEST(Agent, StaysReadyWhileTheClientSendsKeepAlives) {
  FakeDevice device;
  device.become_ready();
  const auto ask = [&device](const std::string& id) { device.receive(keep_alive(device, id)); };
  for (int i = 0; i < 4; ++i) {
    device.pass(seconds{8});
    ask("d1");
    EXPECT_EQ(device.status().state(), DEVICE_READY) << "after " << i;
  }
  ask("");
  ask("another");
  device.pass(seconds{8});
  ask("");
  device.pass(seconds{3});
  EXPECT_EQ(device.work.phase, Phase::stopping) << "only keep-alives for this deployment count";
}

TEST(Agent, FailsAPendingPrepareCommandWhenTheNodeEnds) {
  FakeDevice device;
  device.prepare();
  device.agent.end(false);
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_TRUE(device.agent.ended());
  device.prepare("d2");
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
}

}  // namespace
}  // namespace takt::agent::agent_test
