// Tests validate() on cells that are built in C++. The files in tests/unit/descriptor/cases test the same
// rules on descriptors.
#include <takt/model/validate.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::validate_test {
namespace {

using namespace std::chrono_literals;
using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

auto problem(const std::string& where, const std::string& what) {
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

/// Returns a cell of one device with module a (defined in line 3) and module b (defined in line 5).
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

TEST(Validate, AcceptsAValidCell) { EXPECT_THAT(validate(cell()), IsEmpty()); }

TEST(Validate, RejectsNumbersOutsideTheirRange) {
  const auto device = [](auto change) { return problems_after([&](Cell& c) { change(c.devices[0]); }); };
  EXPECT_THAT(problems_after([](Cell& c) { c.domain = 233; }), ElementsAre(problem("c.xml:1", "domain 233")));
  EXPECT_THAT(problems_after([](Cell& c) { c.domain = -1; }), ElementsAre(problem("c.xml:1", "domain -1")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].priority = 1; }),
              ElementsAre(problem("c.xml:2", "priority 1")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].priority = 99; }),
              ElementsAre(problem("c.xml:2", "priority 99")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].cpu = -1; }), ElementsAre(problem("c.xml:2", "cpu -1")));
  EXPECT_THAT(device([](Device& d) { d.executors[0].cpu = 1024; }),
              ElementsAre(problem("c.xml:2", "cpu 1024")));
  EXPECT_THAT(device([](Device& d) { d.modules[0].period = 0ns; }),
              ElementsAre(problem("c.xml:3", "period of 0 ns")));
  EXPECT_THAT(device([](Device& d) { d.modules[0].period = 999ns; }),
              ElementsAre(problem("c.xml:3", "period of 999 ns")));
  EXPECT_THAT(device([](Device& d) { d.modules[0].period = kMinPeriod; }), IsEmpty());
  EXPECT_THAT(device([](Device& d) { d.modules[0].budget = -1ns; }),
              ElementsAre(problem("c.xml:3", "budget of -1 ns")));
  EXPECT_THAT(device([](Device& d) {
                d.modules[0].budget = 100us;
                d.modules[0].hang = 100us;
              }),
              ElementsAre(problem("c.xml:3", "hangs after 100 us, but may take 100 us")));
  EXPECT_THAT(device([](Device& d) {
                d.modules[0].budget = 100us;
                d.modules[0].tolerance.times = 3;
                d.modules[0].hang = 300us;
              }),
              ElementsAre(problem("c.xml:3", "hangs after 300 us, but may take 3 times 100 us")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].recovery.attempts = 1001; }),
              ElementsAre(problem("c.xml:5", "1001 recovery attempts")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].recovery.backoff = 1h + 1ns; }),
              ElementsAre(problem("c.xml:5", "has a backoff of")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].filename = ""; }),
              ElementsAre(problem("c.xml:5", "empty filename")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].filename = std::string(4097, 'x'); }),
              ElementsAre(problem("c.xml:5", "too long")));
  EXPECT_THAT(device([](Device& d) { d.modules[1].filename += '\0'; }),
              ElementsAre(problem("c.xml:5", "zero byte")));
}

TEST(Validate, RejectsTimesThatDoNotFitTheOperationType) {
  const auto of_a = [](auto change) {
    return problems_after([&](Cell& c) { change(c.devices[0].modules[0]); });
  };
  EXPECT_THAT(of_a([](Module& m) { m.period.reset(); }), ElementsAre(problem("c.xml:3", "has no <period>")));
  EXPECT_THAT(of_a([](Module& m) {
                m.deadline = 1ms;
                m.lines.deadline = 4;
              }),
              ElementsAre(problem("c.xml:4", "has a <deadline>")));
  EXPECT_THAT(of_a([](Module& m) { m.operation = Operation::sporadic; }),
              ElementsAre(problem("c.xml:3", "has no <deadline>"), problem("c.xml:3", "has a <period>")));
  EXPECT_THAT(of_a([](Module& m) { m.operation = Operation::non_real; }),
              ElementsAre(problem("c.xml:3", "has an <executor>")));
  EXPECT_THAT(of_a([](Module& m) {
                m.operation = Operation::non_real;
                m.type = ModuleType::process;
                m.executor.clear();
                m.budget = 1us;
                m.deadline = 1us;
              }),
              ElementsAre(problem("c.xml:3", "is a process and has a <period>"),
                          problem("c.xml:3", "has a <deadline>"), problem("c.xml:3", "has a <budget>")));
}

TEST(Validate, LimitsTheNumberOfExecutorsModulesAndDevices) {
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
  EXPECT_THAT(many(kMaxExecutors + 1, 2, 1), ElementsAre(problem("c.xml:2", "65 executors")));
  EXPECT_THAT(many(1, kMaxModules + 1, 1), ElementsAre(problem("c.xml:2", "10001 modules")));
  EXPECT_THAT(many(1, 2, kMaxDevices + 1), ElementsAre(problem("c.xml:1", "1001 devices")));
  EXPECT_THAT(problems_after([](Cell& c) { c.devices.clear(); }),
              ElementsAre(problem("c.xml:1", "no device")));
  EXPECT_THAT(problems_after([](Cell& c) { c.devices[0].modules.clear(); }),
              ElementsAre(problem("c.xml:2", "no module")));
  EXPECT_THAT(problems_after([](Cell& c) { c.devices[0].executors.clear(); }),
              ElementsAre(problem("c.xml:2", "no executor")));
}

TEST(Validate, RejectsInvalidConnections) {
  const auto with = [](auto... connections) {
    return problems_after([&](Cell& c) { c.connections = {connections...}; });
  };
  Connection queue = connection("out", "in", 8);
  queue.kind = ConnectionKind::queue;
  queue.depth = kMaxDepth;
  Connection other = connection("other", "in", 9);
  EXPECT_THAT(with(queue), IsEmpty());
  EXPECT_THAT(with(queue, other), ElementsAre(problem("c.xml:9", "two writers of 'robot.b.in'")));
  EXPECT_THAT(with(queue, queue), ElementsAre(problem("c.xml:8", "duplicate connection")));
  other.kind = ConnectionKind::queue;
  EXPECT_THAT(with(queue, other), IsEmpty());
  queue.depth = 0;
  EXPECT_THAT(with(queue), ElementsAre(problem("c.xml:8", "depth 0")));
  queue.depth = kMaxDepth + 1;
  EXPECT_THAT(with(queue), ElementsAre(problem("c.xml:8", "depth 65537")));
  Connection latest = connection("out", "in", 8);
  latest.depth = 2;
  EXPECT_THAT(with(latest), ElementsAre(problem("c.xml:8", "kind latest has a depth")));
  latest.depth = 1;
  latest.deadline = 0ns;
  EXPECT_THAT(with(latest), ElementsAre(problem("c.xml:8", "deadline of 0 ns")));
  latest.deadline.reset();
  latest.stale = Stale::error;
  EXPECT_THAT(with(latest), ElementsAre(problem("c.xml:8", "no deadline")));
  latest.stale = Stale::hold;
  latest.lifespan = -1ns;
  EXPECT_THAT(with(latest), ElementsAre(problem("c.xml:8", "lifespan of -1 ns")));
  Connection itself = connection("x", "x", 8);
  itself.to.module = "a";
  EXPECT_THAT(with(itself), ElementsAre(problem("c.xml:8", "connected to itself")));
}

TEST(Validate, RejectsModulesThatWaitForEachOtherForever) {
  const auto stale = [](const std::string& from, const std::string& to, int line) {
    Connection made = connection("out" + std::to_string(line), "in" + std::to_string(line), line);
    made.from.module = from;
    made.to.module = to;
    made.deadline = 1ms;
    made.stale = Stale::error;
    return made;
  };
  const auto with = [](std::vector<Connection> connections) {
    return problems_after([&](Cell& c) {
      while (c.devices[0].modules.size() < 4) {
        c.devices[0].modules.push_back(c.devices[0].modules[0]);
        c.devices[0].modules.back().name =
            std::string(1, static_cast<char>('a' + c.devices[0].modules.size() - 1));
      }
      c.connections = std::move(connections);
    });
  };
  EXPECT_THAT(with({stale("a", "b", 8), stale("b", "c", 9), stale("a", "c", 10)}), IsEmpty());
  EXPECT_THAT(
      with({stale("a", "b", 8), stale("b", "a", 9)}),
      ElementsAre(problem("c.xml:8", "modules robot.a, robot.b wait for each other's values in a cycle")));
  EXPECT_THAT(with({stale("a", "b", 8), stale("b", "c", 9), stale("c", "a", 10), stale("c", "d", 11)}),
              ElementsAre(problem("c.xml:8", "wait for each other's values in a cycle")));
  EXPECT_THAT(with({stale("a", "a", 8)}), ElementsAre(problem("c.xml:8", "that it writes itself")));
  auto holds = stale("b", "a", 9);
  holds.stale = Stale::hold;
  EXPECT_THAT(with({stale("a", "b", 8), holds}), IsEmpty());
}

/// Returns a connection from a topic to the port `to` of module b.
Connection from_topic(const std::string& topic, const std::string& to, int line) {
  Connection outside = connection("", to, line);
  outside.from = {};
  outside.topic = topic;
  return outside;
}
Connection to_topic(const std::string& from, const std::string& topic, int line) {
  Connection outside = connection(from, "", line);
  outside.to = {};
  outside.topic = topic;
  return outside;
}

TEST(Validate, AllowsAConnectionWithOneEndOnlyIfItHasATopic) {
  const auto with = [](auto... connections) {
    return problems_after([&](Cell& c) { c.connections = {connections...}; });
  };
  EXPECT_THAT(with(from_topic("t", "in", 8), to_topic("out", "u", 9)), IsEmpty());
  EXPECT_THAT(with(from_topic("", "in", 8)), ElementsAre(problem("c.xml:8", "has no attribute 'from'")));
  EXPECT_THAT(with(to_topic("out", "", 8)), ElementsAre(problem("c.xml:8", "has no attribute 'to'")));
  Connection nothing;
  nothing.topic = "t";
  nothing.line = 8;
  EXPECT_THAT(with(nothing), ElementsAre(problem("c.xml:8", "neither attribute 'from' nor attribute 'to'")));
  Connection stale = to_topic("out", "t", 8);
  stale.deadline = 1ms;
  EXPECT_THAT(with(stale), IsEmpty());
  stale.stale = Stale::error;
  EXPECT_THAT(with(stale), ElementsAre(problem("c.xml:8", "has stale=\"error\" but no attribute 'to'")));
  // An incomplete value of `from` or `to` is invalid; it does not count as a missing attribute.
  Connection half = from_topic("t", "in", 8);
  half.from.port = "out";
  EXPECT_THAT(with(half), ElementsAre(problem("c.xml:8", "attribute 'from' is not valid: '..out'")));
  half = to_topic("out", "t", 8);
  half.to.device = "robot";
  EXPECT_THAT(with(half), ElementsAre(problem("c.xml:8", "attribute 'to' is not valid: 'robot'")));
}

TEST(Validate, RejectsInvalidTopics) {
  const auto with = [](const std::string& topic, std::optional<int> domain = {}) {
    return problems_after([&](Cell& c) {
      c.connections = {connection("out", "in", 8)};
      c.connections[0].topic = topic;
      c.connections[0].domain = domain;
    });
  };
  EXPECT_THAT(with("rt/x"), IsEmpty());
  EXPECT_THAT(with("takt"), IsEmpty());
  EXPECT_THAT(with("a/takt/"), IsEmpty());
  EXPECT_THAT(with(std::string(255, 'x')), IsEmpty());
  EXPECT_THAT(with("t", 0), IsEmpty());
  EXPECT_THAT(with("t", 232), IsEmpty());
  EXPECT_THAT(with(std::string(256, 'x')), ElementsAre(problem("c.xml:8", "not a valid topic")));
  EXPECT_THAT(with("a b"), ElementsAre(problem("c.xml:8", "not a valid topic")));
  EXPECT_THAT(with("takt/x"), ElementsAre(problem("c.xml:8", "begins with takt/")));
  EXPECT_THAT(with("t", 233), ElementsAre(problem("c.xml:8", "domain 233")));
  EXPECT_THAT(with("t", -1), ElementsAre(problem("c.xml:8", "domain -1")));
  EXPECT_THAT(with("", 3), ElementsAre(problem("c.xml:8", "a domain but no topic")));
}

TEST(Validate, CountsAllWritersOfAPortIncludingThoseOutsideTheCell) {
  const auto with = [](auto... connections) {
    return problems_after([&](Cell& c) { c.connections = {connections...}; });
  };
  const auto two = [](int line) {
    return ElementsAre(problem("c.xml:" + std::to_string(line), "two writers of 'robot.b.in'"));
  };
  EXPECT_THAT(with(connection("out", "in", 8), from_topic("t", "in", 9)), two(9));
  EXPECT_THAT(with(from_topic("t", "in", 8), connection("out", "in", 9)), two(9));
  EXPECT_THAT(with(from_topic("t", "in", 8), from_topic("u", "in", 9)), two(9));
  EXPECT_THAT(with(from_topic("t", "in", 8), from_topic("t", "other", 9)), IsEmpty());

  // All writers of a topic count, even if the connection of the reader names only one of them.
  Connection named = connection("out", "in", 8);
  named.topic = "t";
  Connection other = to_topic("other", "t", 9);
  EXPECT_THAT(with(named, other), two(8));
  EXPECT_THAT(with(to_topic("out", "t", 7), other, from_topic("t", "in", 8)), two(8));
  EXPECT_THAT(with(to_topic("out", "t", 7), from_topic("t", "in", 8)), IsEmpty());
  EXPECT_THAT(with(named, to_topic("out", "t", 9)), IsEmpty()) << "both connections have the same writer";
  other.domain = 5;
  EXPECT_THAT(with(named, other), IsEmpty());
  named.domain = 5;
  EXPECT_THAT(with(named, other), two(8));
  named.domain.reset();
  other.domain = 0;
  EXPECT_THAT(with(named, other), two(8)) << "0 is the cell's domain";
  other.domain = 6;
  const auto in_domain_6 = problems_after([&](Cell& c) {
    c.domain = 6;
    c.connections = {named, other};
  });
  EXPECT_THAT(in_domain_6, two(8)) << "6 is the cell's domain";
  other.domain.reset();
  named.kind = ConnectionKind::queue;
  EXPECT_THAT(with(named, other), IsEmpty());
}

TEST(Validate, RejectsDuplicateConnections) {
  const auto with = [](auto... connections) {
    return problems_after([&](Cell& c) { c.connections = {connections...}; });
  };
  Connection queue = from_topic("t", "in", 8);
  queue.kind = ConnectionKind::queue;
  Connection again = queue;
  again.line = 9;
  EXPECT_THAT(with(queue, again),
              ElementsAre(problem("c.xml:9", "duplicate connection to 'robot.b.in', topic 't'")));
  again.domain = 0;
  EXPECT_THAT(with(queue, again), ElementsAre(problem("c.xml:9", "duplicate connection")));
  again.domain = 1;
  EXPECT_THAT(with(queue, again), IsEmpty());
  EXPECT_THAT(with(to_topic("out", "t", 8), to_topic("out", "t", 9)),
              ElementsAre(problem("c.xml:9", "duplicate connection from 'robot.a.out', topic 't'")));
  EXPECT_THAT(with(to_topic("out", "t", 8), to_topic("out", "u", 9)), IsEmpty());
}

TEST(Validate, RejectsADefaultTopicThatIsTooLong) {
  const auto of = [](std::size_t length, bool between_devices) {
    return problems_after([&](Cell& c) {
      // The default topic is takt/, the name of the cell, and three names of 63 characters with a / before
      // each.
      c.name = std::string(length - 192 - 5, 'c');
      Device other = c.devices[0];
      for (std::string* name : {&c.devices[0].name, &c.devices[0].modules[0].name})
        *name = std::string(63, 'x');
      c.devices.push_back(other);
      c.connections = {connection(std::string(63, 'x'), "in", 8)};
      c.connections[0].from.device = c.connections[0].from.module = std::string(63, 'x');
      if (!between_devices) c.connections[0].to.device = std::string(63, 'x');
    });
  };
  EXPECT_THAT(of(255, true), IsEmpty());
  EXPECT_THAT(of(256, true), ElementsAre(problem("c.xml:8", "would have 256 characters")));
  EXPECT_THAT(of(256, false), IsEmpty()) << "a connection within one device has no topic";
}

TEST(Validate, RejectsElementsForSporadicModulesInOtherModules) {
  const auto of_a = [](auto change) {
    return problems_after([&](Cell& c) { change(c.devices[0].modules[0]); });
  };
  const auto sporadic = [](Module& m) {
    m.operation = Operation::sporadic;
    m.period.reset();
    m.deadline = 1ms;
  };
  EXPECT_THAT(of_a([&](Module& m) {
                sporadic(m);
                m.miss = Miss::error;
                m.dispatch = Dispatch::immediate;
                m.interarrival = 1ns;
              }),
              IsEmpty());
  EXPECT_THAT(of_a([&](Module& m) {
                sporadic(m);
                m.interarrival = 0ns;
                m.lines.interarrival = 4;
              }),
              ElementsAre(problem("c.xml:4", "interarrival of 0 ns")));
  EXPECT_THAT(of_a([](Module& m) { m.dispatch = Dispatch::immediate; }),
              ElementsAre(problem("c.xml:3", "periodic module 'a' has a <dispatch>")));
  EXPECT_THAT(of_a([](Module& m) { m.lines.dispatch = 4; }),
              ElementsAre(problem("c.xml:4", "has a <dispatch>")));
  EXPECT_THAT(of_a([](Module& m) { m.interarrival = 1ms; }),
              ElementsAre(problem("c.xml:3", "has an <interarrival>")));
  EXPECT_THAT(of_a([](Module& m) { m.miss = Miss::error; }),
              ElementsAre(problem("c.xml:3", "missed deadline")));
  EXPECT_THAT(of_a([](Module& m) {
                m.operation = Operation::non_real;
                m.executor.clear();
                m.dispatch = Dispatch::immediate;
                m.interarrival = 1ms;
              }),
              ElementsAre(problem("c.xml:3", "non-real module 'a' has a <dispatch>"),
                          problem("c.xml:3", "has an <interarrival>")));
}

TEST(Validate, RejectsInvalidDiscoverySettings) {
  using Kind = Discovery::Kind;
  const auto with = [](Discovery discovery, const std::string& server_device = "") {
    return problems_after([&](Cell& c) {
      c.discovery = std::move(discovery);
      c.server_device = server_device;
    });
  };
  const auto peers = [&](std::vector<std::string> names) {
    return with({Kind::peers, std::move(names), {}, {}});
  };
  EXPECT_THAT(peers({"10.0.0.1", "line.local"}), IsEmpty());
  EXPECT_THAT(peers({}), ElementsAre(problem("c.xml:1", "requires peers")));
  EXPECT_THAT(peers({"a", "a"}), ElementsAre(problem("c.xml:1", "duplicate peer 'a'")));
  EXPECT_THAT(peers({"a:1", ""}), ElementsAre(problem("c.xml:1", "'a:1' is not a valid peer"),
                                              problem("c.xml:1", "'' is not a valid peer")));
  std::vector<std::string> many;
  for (std::size_t i = 0; i < kMaxPeers; ++i) many.push_back("p" + std::to_string(i));
  EXPECT_THAT(peers(many), IsEmpty());
  many.emplace_back("one.more");
  EXPECT_THAT(peers(many), ElementsAre(problem("c.xml:1", "more than 256 peers")));
  EXPECT_THAT(with({Kind::multicast, {"a"}, {}, {}}),
              ElementsAre(problem("c.xml:1", "not discovery=\"peers\"")));

  EXPECT_THAT(with({Kind::server, {}, "h:1", {}}), IsEmpty());
  EXPECT_THAT(with({Kind::server, {}, "h:1", {}}, "robot"), IsEmpty());
  EXPECT_THAT(with({Kind::server, {}, "", {}}), ElementsAre(problem("c.xml:1", "requires a server")));
  EXPECT_THAT(with({Kind::server, {}, "h", {}}),
              ElementsAre(problem("c.xml:1", "'h' is not a valid discovery server")));
  EXPECT_THAT(with({Kind::server, {}, "h:1", {}}, "robt"),
              ElementsAre(problem("c.xml:1", "unknown device 'robt'")));
  EXPECT_THAT(with({Kind::peers, {"a"}, "h:1", {}}, "robot"),
              ElementsAre(problem("c.xml:1", "not discovery=\"server\""),
                          problem("c.xml:1", "not discovery=\"server\"")));
}

TEST(Validate, LimitsTheNumberOfConnections) {
  const auto many = [](std::size_t number) {
    return problems_after([&](Cell& c) {
      for (std::size_t i = 0; i < number; ++i) {
        c.connections.push_back(connection("out", "in" + std::to_string(i), 8));
      }
    });
  };
  EXPECT_THAT(many(kMaxConnections), IsEmpty());
  EXPECT_THAT(many(kMaxConnections + 1), ElementsAre(problem("c.xml:1", "more than 100000 connections")));
}

TEST(Validate, NamesTheLineOfTheFirstOfTwoDuplicates) {
  const Problems problems = problems_after([](Cell& c) { c.devices[0].modules[1].name = "a"; });
  ASSERT_THAT(problems, ElementsAre(problem("c.xml:5", "duplicate module 'a'")));
  EXPECT_THAT(problems[0].fix, HasSubstr("line 3"));
}

TEST(Validate, SearchesAllDevicesWithTheSameNameForAModule) {
  const auto problems = [](const std::string& module) {
    return problems_after([&](Cell& c) {
      Device second = c.devices[0];
      second.line = 6;
      second.modules = {servo("a", 7), servo("gauge", 8)};
      c.devices.push_back(second);
      c.connections = {connection("out", "in", 9)};
      c.connections[0].to.module = module;
    });
  };
  EXPECT_THAT(problems("gauge"), ElementsAre(problem("c.xml:6", "duplicate device 'robot'")));
  const Problems unknown = problems("xyz");
  ASSERT_THAT(unknown, ElementsAre(problem("c.xml:6", "duplicate device 'robot'"),
                                   problem("c.xml:9", "unknown module 'xyz' of device 'robot'")));
  EXPECT_EQ(unknown[1].fix, "use a, b or gauge");
  EXPECT_EQ(problems("Gauge")[1].fix,
            "did you mean gauge? The module on line 8 has this name from its <filename>");
}

TEST(Validate, DoesNotReportErrorsCausedByAnElementThatCouldNotBeRead) {
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

TEST(Validate, ReportsALimitedNumberOfProblemsSortedByLine) {
  Problems problems = problems_after([](Cell& c) {
    c.devices[0].modules[0].line = 7;
    for (Module& module : c.devices[0].modules) module.period.reset();
  });
  EXPECT_THAT(problems, ElementsAre(problem("c.xml:5", "<period>"), problem("c.xml:7", "<period>")));
  problems = problems_after([](Cell& c) {
    for (int i = 0; i < 2000; ++i) c.devices[0].modules.push_back(servo("a", 9));
  });
  EXPECT_EQ(problems.size(), kMaxProblems);
}

TEST(Validate, NamesTheCellInProblemsIfItHasNoFile) {
  Cell made;
  made.name = "made";
  EXPECT_THAT(validate(made), ElementsAre(problem("cell made", "no device")));
}

TEST(Validate, AcceptsServicesAndTheirConnections) {
  Cell cell = validate_test::cell();
  cell.services = {{.client = {"robot", "a", "ask"}, .server = {"robot", "b", "grip"}, .line = 7}};
  EXPECT_THAT(validate(cell), IsEmpty());
  connect_services(cell);
  EXPECT_EQ(cell.connections.size(), 2U);
  EXPECT_THAT(validate(cell), IsEmpty());
}

}  // namespace
}  // namespace takt::model::validate_test
