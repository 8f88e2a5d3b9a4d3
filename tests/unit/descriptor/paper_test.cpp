#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <folders.hpp>
#include <takt/descriptor/descriptor.hpp>

namespace takt::descriptor::paper_test {
namespace {

using model::ModuleType;
using model::Operation;
using namespace std::chrono_literals;

// The expected values of a module in Figure 1 of the paper.
struct Expected {
  const char* name;
  const char* filename;
  ModuleType type;
  Operation operation;
  std::optional<Nanoseconds> period;
  std::optional<Nanoseconds> deadline;
  int priority;
  int line;
};

const Expected kFigure1[] = {
    {"controller1", "build/controller1.so", ModuleType::thread, Operation::periodic, 600us, {}, 3, 10},
    {"control2", "./control2.so", ModuleType::thread, Operation::periodic, 100us, {}, 2, 20},
    {"control3", "./control3.so", ModuleType::thread, Operation::periodic, 100us, {}, 1, 27},
    {"control4", "./control4.exe", ModuleType::process, Operation::periodic, 300us, {}, 4, 34},
    {"emergency", "./emergency.so", ModuleType::thread, Operation::sporadic, {}, 100us, 1, 41},
    {"vision", "./vision.exe", ModuleType::process, Operation::sporadic, {}, 10ms, 2, 48},
    {"monitoring", "./monitoring.exe", ModuleType::process, Operation::non_real, {}, {}, 0, 55},
};

TEST(PaperDescriptor, HasTheSevenModulesOfFigure1) {
  const auto cell = load(source_path("deploy/module.xml"));
  ASSERT_TRUE(cell) << to_text(cell.problems());
  EXPECT_EQ(cell->name, "module");
  EXPECT_FALSE(cell->domain_given);
  EXPECT_TRUE(cell->connections.empty());
  ASSERT_EQ(cell->devices.size(), 1U);
  const model::Device& device = cell->devices[0];
  EXPECT_EQ(device.name, "module");
  ASSERT_EQ(device.executors.size(), 1U);
  EXPECT_EQ(device.executors[0].name, "main");
  EXPECT_EQ(device.executors[0].priority, 80);
  EXPECT_EQ(device.executors[0].wakeup, model::Wakeup::hybrid);

  ASSERT_EQ(device.modules.size(), std::size(kFigure1));
  for (std::size_t i = 0; i < std::size(kFigure1); ++i) {
    const model::Module& module = device.modules[i];
    const Expected& expected = kFigure1[i];
    SCOPED_TRACE(expected.name);
    EXPECT_EQ(module.name, expected.name);
    EXPECT_EQ(module.filename, expected.filename);
    EXPECT_EQ(module.type, expected.type);
    EXPECT_EQ(module.operation, expected.operation);
    EXPECT_EQ(module.period, expected.period);
    EXPECT_EQ(module.deadline, expected.deadline);
    EXPECT_EQ(module.priority, expected.priority);
    EXPECT_EQ(module.line, expected.line);
    EXPECT_EQ(module.executor, expected.operation == Operation::non_real ? "" : "main");
    EXPECT_FALSE(module.budget);
  }
  ASSERT_EQ(device.modules[0].properties.size(), 1U);
  EXPECT_EQ(device.modules[0].properties[0].name, "counter");
  EXPECT_EQ(device.modules[0].properties[0].value, "5");
}

TEST(CellDescriptor, ReadsACellOfTwoDevices) {
  const auto cell = load(source_path("tests/unit/descriptor/cases/good/cell.xml"));
  ASSERT_TRUE(cell) << to_text(cell.problems());
  EXPECT_EQ(cell->name, "palletizing");
  EXPECT_EQ(cell->domain, 7);
  EXPECT_TRUE(cell->domain_given);
  ASSERT_EQ(cell->devices.size(), 2U);

  const model::Device& robot = cell->devices[0];
  EXPECT_EQ(robot.name, "robot");
  ASSERT_EQ(robot.executors.size(), 1U);
  EXPECT_EQ(robot.executors[0].name, "motion");
  EXPECT_EQ(robot.executors[0].cpu, 1);
  EXPECT_EQ(robot.executors[0].priority, 80);
  EXPECT_EQ(robot.executors[0].wakeup, model::Wakeup::hybrid);
  ASSERT_EQ(robot.modules.size(), 1U);
  const model::Module& trajectory = robot.modules[0];
  EXPECT_EQ(trajectory.name, "trajectory");
  EXPECT_EQ(trajectory.period, 1ms);
  EXPECT_EQ(trajectory.budget, 200us);
  EXPECT_EQ(trajectory.executor, "motion");
  EXPECT_EQ(trajectory.recovery.attempts, 3);
  EXPECT_EQ(trajectory.recovery.backoff, 100ms);
  EXPECT_EQ(trajectory.recovery.then, model::GiveUp::destruct);
  ASSERT_EQ(trajectory.properties.size(), 1U);
  EXPECT_EQ(trajectory.properties[0].value, "0.5");

  EXPECT_EQ(cell->devices[1].modules.at(0).executor, "main");
  ASSERT_EQ(cell->connections.size(), 1U);
  const model::Connection& connection = cell->connections[0];
  EXPECT_EQ(connection.from.device, "robot");
  EXPECT_EQ(connection.from.module, "trajectory");
  EXPECT_EQ(connection.from.port, "setpoint");
  EXPECT_EQ(connection.to.module, "conveyor");
  EXPECT_EQ(connection.kind, model::ConnectionKind::latest);
  EXPECT_EQ(connection.deadline, 20ms);
  EXPECT_EQ(connection.stale, model::Stale::error);
  EXPECT_EQ(connection.depth, 1);
  EXPECT_EQ(connection.reliability, model::Reliability::best_effort);
  EXPECT_FALSE(connection.lifespan);
  EXPECT_EQ(connection.topic, "");
  EXPECT_FALSE(connection.domain);

  const model::Module& conveyor = cell->devices[1].modules[0];
  EXPECT_EQ(conveyor.miss, model::Miss::count);
  EXPECT_EQ(conveyor.dispatch, model::Dispatch::row);
  EXPECT_FALSE(conveyor.interarrival);
  EXPECT_EQ(cell->discovery.kind, model::Discovery::Kind::multicast);
  EXPECT_EQ(cell->server_device, "");
}

TEST(CellDescriptor, ReadsEveryElementAndAttribute) {
  const auto cell = load(source_path("tests/unit/descriptor/cases/good/everything.xml"));
  ASSERT_TRUE(cell) << to_text(cell.problems());
  EXPECT_EQ(cell->discovery.kind, model::Discovery::Kind::server);
  EXPECT_EQ(cell->discovery.server, "10.0.0.1:11811");
  EXPECT_FALSE(cell->discovery.serve);
  EXPECT_EQ(cell->server_device, "robot");

  const model::Executor& motion = cell->devices.at(0).executors.at(0);
  EXPECT_EQ(motion.priority, 80);
  EXPECT_FALSE(motion.rate_monotonic);
  EXPECT_DOUBLE_EQ(motion.spin_share, 0.3);
  EXPECT_EQ(motion.overrun.what, model::Overrun::catch_up);
  EXPECT_EQ(motion.overrun.limit, 3);
  EXPECT_EQ(motion.offsets, model::Offsets::automatic);
  EXPECT_EQ(motion.timing, model::Timing::let);
  EXPECT_TRUE(motion.own_host);
  const model::Module& trajectory = cell->devices[0].modules.at(0);
  EXPECT_EQ(trajectory.offset, 100us);
  EXPECT_TRUE(trajectory.retain);
  EXPECT_EQ(trajectory.tolerance.times, 2);
  EXPECT_EQ(trajectory.tolerance.in_a_row, 5);
  EXPECT_EQ(trajectory.hang, 30ms);
  EXPECT_EQ(model::contract_of(cell->devices[0], trajectory).limit, 2) << "the module's own contract";
  EXPECT_EQ(model::timing_of(cell->devices[0], trajectory), model::Timing::let);

  const model::Module& conveyor = cell->devices.at(1).modules.at(0);
  EXPECT_EQ(conveyor.deadline, 5ms);
  EXPECT_EQ(conveyor.miss, model::Miss::error);
  EXPECT_EQ(conveyor.dispatch, model::Dispatch::immediate);
  EXPECT_EQ(conveyor.interarrival, 1ms);
  EXPECT_EQ(conveyor.lines.deadline, 30);
  EXPECT_EQ(conveyor.lines.dispatch, 31);
  EXPECT_EQ(conveyor.lines.interarrival, 32);
  EXPECT_EQ(conveyor.arguments, (std::vector<std::string>{"--camera", "0"}));
  EXPECT_EQ(conveyor.lines.arguments, 35);

  ASSERT_EQ(cell->connections.size(), 3U);
  const model::Connection& connection = cell->connections[0];
  EXPECT_EQ(connection.kind, model::ConnectionKind::queue);
  EXPECT_EQ(connection.depth, 8);
  EXPECT_EQ(connection.reliability, model::Reliability::best_effort);
  EXPECT_EQ(connection.deadline, 20ms);
  EXPECT_EQ(connection.lifespan, 50ms);
  EXPECT_EQ(connection.stale, model::Stale::error);
  EXPECT_EQ(connection.topic, "rt/setpoint");
  EXPECT_EQ(connection.domain, 9);

  const auto peers = load(source_path("tests/unit/descriptor/cases/good/peers.xml"));
  ASSERT_TRUE(peers) << to_text(peers.problems());
  EXPECT_EQ(peers->discovery.kind, model::Discovery::Kind::peers);
  EXPECT_THAT(peers->discovery.peers, testing::ElementsAre("10.0.0.1", "line.local"));
}

}  // namespace
}  // namespace takt::descriptor::paper_test
