// What a cell made by a program can be wrong about. What a descriptor can be wrong about lies in
// tests/unit/descriptor/cases.
#include <takt/model/validate.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

auto said(const std::string& where, const std::string& what) {
  return AllOf(Field(&Problem::where, where), Field(&Problem::what, HasSubstr(what)),
               Field(&Problem::fix, Not(IsEmpty())));
}

Module servo(const std::string& name, int line) {
  Module module;
  module.name = name;
  module.filename = name + ".so";
  module.period = 1ms;
  module.executor = "main";
  module.line = line;
  return module;
}

/// A cell of one device with modules a (line 3) and b (line 5).
Cell cell() {
  Device device;
  device.name = "robot";
  device.line = 2;
  device.executors.emplace_back().line = 2;
  device.modules = {servo("a", 3), servo("b", 5)};
  Cell cell;
  cell.name = "cell";
  cell.file = "c.xml";
  cell.line = 1;
  cell.devices.push_back(device);
  return cell;
}

Connection connection(const std::string& from, const std::string& to, int line) {
  Connection connection;
  connection.from = {"robot", "a", from};
  connection.to = {"robot", "b", to};
  connection.line = line;
  return connection;
}

template <class Break>
Problems problems_after(Break change) {
  Cell broken = cell();
  change(broken);
  return validate(broken);
}

TEST(Validate, HasNothingToSayOfAGoodCell) { EXPECT_THAT(validate(cell()), IsEmpty()); }

TEST(Validate, RefusesNumbersOutOfTheirRange) {
  const auto device = [](auto change) { return problems_after([&](Cell& c) { change(c.devices[0]); }); };
  EXPECT_THAT(problems_after([](Cell& c) { c.domain = 233; }), ElementsAre(said("c.xml:1", "domain 233")));
  EXPECT_THAT(problems_after([](Cell& c) { c.domain = -1; }), ElementsAre(said("c.xml:1", "domain -1")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].priority = 1; }),
              ElementsAre(said("c.xml:2", "priority 1")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].priority = 99; }),
              ElementsAre(said("c.xml:2", "priority 99")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].cpu = -1; }), ElementsAre(said("c.xml:2", "cpu -1")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].cpu = 1024; }), ElementsAre(said("c.xml:2", "cpu 1024")));
  EXPECT_THAT(device([](Device& d) { d.modules[0].period = 0ns; }),
              ElementsAre(said("c.xml:3", "period of 0 ns")));
  EXPECT_THAT(device([](Device& d) { d.modules[0].budget = -1ns; }),
              ElementsAre(said("c.xml:3", "budget of -1 ns")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].recovery.attempts = 1001; }),
              ElementsAre(said("c.xml:5", "1001 times")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].recovery.backoff = 1h + 1ns; }),
              ElementsAre(said("c.xml:5", "waits")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].filename = ""; }),
              ElementsAre(said("c.xml:5", "empty filename")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].filename = std::string(4097, 'x'); }),
              ElementsAre(said("c.xml:5", "too long")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].filename += '\0'; }),
              ElementsAre(said("c.xml:5", "zero byte")));
}

TEST(Validate, RefusesTimesOnTheWrongKindOfModule) {
  const auto of_a = [](auto change) {
    return problems_after([&](Cell& c) { change(c.devices[0].modules[0]); });
  };
  EXPECT_THAT(of_a([](Module& m) { m.period.reset(); }), ElementsAre(said("c.xml:3", "has no <period>")));
  EXPECT_THAT(of_a([](Module& m) {
                m.deadline = 1ms;
                m.lines.deadline = 4;
              }),
              ElementsAre(said("c.xml:4", "has a <deadline>")));
  EXPECT_THAT(of_a([](Module& m) { m.operation = Operation::sporadic; }),
              ElementsAre(said("c.xml:3", "has no <deadline>"), said("c.xml:3", "has a <period>")));
  EXPECT_THAT(of_a([](Module& m) { m.operation = Operation::non_real; }),
              ElementsAre(said("c.xml:3", "has an <executor>")));
  EXPECT_THAT(of_a([](Module& m) {
                m.operation = Operation::non_real;
                m.type = ModuleType::process;
                m.executor.clear();
                m.budget = 1us;
                m.deadline = 1us;
              }),
              ElementsAre(said("c.xml:3", "is a process and has a <period>"),
                          said("c.xml:3", "has a <deadline>"), said("c.xml:3", "has a <budget>")));
}

TEST(Validate, RefusesMoreThanTheBounds) {
  const auto many = [](std::size_t executors, std::size_t modules, std::size_t devices) {
    Cell large = cell();
    Device& device = large.devices[0];
    for (std::size_t i = device.executors.size(); i < executors; ++i) {
      device.executors.emplace_back().name = "e" + std::to_string(i);
    }
    for (std::size_t i = device.modules.size(); i < modules; ++i)
      device.modules.push_back(servo("m" + std::to_string(i), 9));
    for (std::size_t i = 1; i < devices; ++i) {
      large.devices.push_back(cell().devices[0]);
      large.devices.back().name = "d" + std::to_string(i);
    }
    return validate(large);
  };
  EXPECT_THAT(many(kMaxExecutors, kMaxModules, kMaxDevices), IsEmpty());
  EXPECT_THAT(many(kMaxExecutors + 1, 2, 1), ElementsAre(said("c.xml:2", "65 executors")));
  EXPECT_THAT(many(1, kMaxModules + 1, 1), ElementsAre(said("c.xml:2", "10001 modules")));
  EXPECT_THAT(many(1, 2, kMaxDevices + 1), ElementsAre(said("c.xml:1", "1001 devices")));
  EXPECT_THAT(problems_after([](Cell& c) { c.devices.clear(); }), ElementsAre(said("c.xml:1", "no device")));
  EXPECT_THAT(problems_after([](Cell& c) { c.devices[0].modules.clear(); }),
              ElementsAre(said("c.xml:2", "no module")));
  EXPECT_THAT(problems_after([](Cell& c) { c.devices[0].executors.clear(); }),
              ElementsAre(said("c.xml:2", "no executor")));
}

TEST(Validate, RefusesConnectionsThatCannotBe) {
  const auto with = [](auto... connections) {
    return problems_after([&](Cell& c) { c.connections = {connections...}; });
  };
  Connection queue = connection("out", "in", 8);
  queue.kind = ConnectionKind::queue;
  queue.depth = kMaxDepth;
  Connection other = connection("other", "in", 9);
  EXPECT_THAT(with(queue), IsEmpty());
  EXPECT_THAT(with(queue, other), ElementsAre(said("c.xml:9", "two writers of 'robot.b.in'")));
  EXPECT_THAT(with(queue, queue), ElementsAre(said("c.xml:8", "duplicate connection")));
  other.kind = ConnectionKind::queue;
  EXPECT_THAT(with(queue, other), IsEmpty());
  queue.depth = 0;
  EXPECT_THAT(with(queue), ElementsAre(said("c.xml:8", "depth 0")));
  queue.depth = kMaxDepth + 1;
  EXPECT_THAT(with(queue), ElementsAre(said("c.xml:8", "depth 65537")));
  Connection latest = connection("out", "in", 8);
  latest.depth = 2;
  EXPECT_THAT(with(latest), ElementsAre(said("c.xml:8", "kind latest has a depth")));
  latest.depth = 1;
  latest.deadline = 0ns;
  EXPECT_THAT(with(latest), ElementsAre(said("c.xml:8", "deadline of 0 ns")));
  latest.deadline.reset();
  latest.stale = Stale::error;
  EXPECT_THAT(with(latest), ElementsAre(said("c.xml:8", "no deadline")));
  Connection itself = connection("x", "x", 8);
  itself.to.module = "a";
  EXPECT_THAT(with(itself), ElementsAre(said("c.xml:8", "connected to itself")));
}

TEST(Validate, NamesTheFirstOfADuplicate) {
  const Problems problems = problems_after([](Cell& c) { c.devices[0].modules[1].name = "a"; });
  ASSERT_THAT(problems, ElementsAre(said("c.xml:5", "duplicate module 'a'")));
  EXPECT_THAT(problems[0].fix, HasSubstr("line 3"));
}

TEST(Validate, SaysNothingThatFollowsFromAGap) {
  Cell broken = cell();
  broken.connections = {connection("out", "in", 8)};
  broken.connections[0].to.module = "unread";
  broken.devices[0].modules[0].executor = "unread";
  EXPECT_EQ(validate(broken).size(), 2U);
  EXPECT_THAT(
      validate(broken,
               {.devices = false, .of_device = {{.executors = true, .modules = true}}, .without_ends = {}}),
      IsEmpty());
  broken.connections[0].to.device = "unread";
  broken.devices[0].modules[0].executor = "main";
  EXPECT_EQ(validate(broken).size(), 1U);
  EXPECT_THAT(validate(broken, {.devices = true, .of_device = {}, .without_ends = {}}), IsEmpty());
}

TEST(Validate, TellsProblemsByLineAndNotMoreThanTheMost) {
  Problems problems = problems_after([](Cell& c) {
    c.devices[0].modules[0].line = 7;
    for (Module& module : c.devices[0].modules) module.period.reset();
  });
  EXPECT_THAT(problems, ElementsAre(said("c.xml:5", "<period>"), said("c.xml:7", "<period>")));
  problems = problems_after([](Cell& c) {
    for (int i = 0; i < 2000; ++i) c.devices[0].modules.push_back(servo("a", 9));
  });
  EXPECT_EQ(problems.size(), kMaxProblems);
}

TEST(Validate, NamesTheCellWhereThereIsNoFile) {
  Cell made;
  made.name = "made";
  EXPECT_THAT(validate(made), ElementsAre(said("cell made", "no device")));
}

}  // namespace
}  // namespace takt::model
