#include <takt/supervision/wiring.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <string_view>

#include <takt/channel/release_slot.hpp>

namespace takt::supervision::wiring_test {
namespace {

using model::Direction;
using std::chrono::milliseconds;

/// A cell with two devices. The test plans the wiring of "here", which has modules a (C++), b (C++), c (C)
/// and p (a sporadic process module with immediate dispatch). "there" is the other device.
class PlannedWiring : public testing::Test {
 protected:
  PlannedWiring() {
    cell.name = "cell";
    cell.devices = {{.name = "here", .executors = {{}}, .modules = {}},
                    {.name = "there", .executors = {{}}, .modules = {}}};
    const auto ports_of = [](bool object) {
      const model::Type type{"t::T", {{.name = "x", .scalar = model::Scalar::float64}}};
      return model::ModulePorts{{{"in", Direction::in, type, "", object},
                                 {"event", Direction::event, type, "", object},
                                 {"out", Direction::out, type, "", object}}};
    };
    for (const char* name : {"a", "b", "c", "p"}) {
      model::Module module;
      module.name = name;
      if (module.name == "p") {
        module.type = model::ModuleType::process;
        module.operation = model::Operation::sporadic;
        module.dispatch = model::Dispatch::immediate;
      }
      cell.devices[0].modules.push_back(module);
      ports.push_back(ports_of(module.name == "a" || module.name == "b"));
    }
  }
  static model::Endpoint end(const std::string& device, const std::string& module, const std::string& port) {
    return {device, module, port};
  }
  model::Connection& connect(const model::Endpoint& from, const model::Endpoint& to) {
    model::Connection& connection = cell.connections.emplace_back();
    connection.from = from;
    connection.to = to;
    return connection;
  }
  WiringPlan plan() const { return plan_wiring(cell, 0, ports); }
  static std::vector<PlannedLink> local(const WiringPlan& plan) {
    std::vector<PlannedLink> links;
    std::copy_if(plan.links.begin(), plan.links.end(), std::back_inserter(links),
                 [](const PlannedLink& l) { return l.from.module && l.to.module; });
    return links;
  }
  static const PlannedFlow& flow(const WiringPlan& plan, std::string_view topic) {
    static const PlannedFlow none{};
    const auto found = std::find_if(plan.flows.begin(), plan.flows.end(),
                                    [&](const PlannedFlow& f) { return f.topic == topic; });
    return found == plan.flows.end() ? none : *found;
  }

  model::Cell cell;
  std::vector<model::ModulePorts> ports;
};

TEST_F(PlannedWiring, PlansAFlowForObserversOfEveryOutput) {
  const WiringPlan plan = this->plan();
  ASSERT_EQ(plan.flows.size(), 4U);
  for (const PlannedFlow& flow : plan.flows) {
    EXPECT_TRUE(flow.outgoing);
    EXPECT_FALSE(flow.connected);
    const PlannedLink& link = plan.links.at(flow.links.at(0));
    EXPECT_FALSE(link.options.enabled) << "nothing is written without observers";
    EXPECT_EQ(link.options.wake_bits, channel::kGatewayBit);
  }
  EXPECT_EQ(flow(plan, "takt/cell/here/a/out").links.size(), 1U);
}

TEST_F(PlannedWiring, PassesSamplesAsObjectsOnlyBetweenCppModules) {
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "a", "out"), end("here", "c", "in"));
  const auto links = local(plan());
  ASSERT_EQ(links.size(), 2U);
  EXPECT_TRUE(links[0].typed);
  EXPECT_EQ(links[0].options.payload, 0U);
  EXPECT_FALSE(links[1].typed);
  EXPECT_EQ(links[1].options.payload, model::max_size((*ports[0])[2].type));
  EXPECT_EQ(links[1].to, (LinkEnd{2, "in"}));
}

TEST_F(PlannedWiring, PassesSamplesAsBytesBetweenHosts) {
  connect(end("here", "a", "out"), end("here", "b", "in"));
  model::Device& device = cell.devices[0];
  model::Executor& alone = device.executors.emplace_back();
  alone.name = "alone";
  alone.own_host = true;
  device.modules[1].operation = model::Operation::periodic;
  device.modules[1].executor = "alone";
  const PlannedLink link = local(plan()).at(0);
  EXPECT_FALSE(link.typed);
  EXPECT_EQ(link.options.payload, model::max_size((*ports[0])[2].type));
}

TEST_F(PlannedWiring, PassesSamplesAsBytesWithinAnExecutorsOwnHost) {
  connect(end("here", "a", "out"), end("here", "b", "in"));
  model::Device& device = cell.devices[0];
  model::Executor& alone = device.executors.emplace_back();
  alone.name = "alone";
  alone.own_host = true;
  for (const std::size_t module : {0U, 1U}) {
    device.modules[module].operation = model::Operation::periodic;
    device.modules[module].executor = "alone";
  }
  EXPECT_FALSE(local(plan()).at(0).typed);
}

TEST_F(PlannedWiring, GivesEachLinkTheQosOfItsConnection) {
  auto& connection = connect(end("here", "a", "out"), end("here", "b", "in"));
  connection.kind = model::ConnectionKind::queue;
  connection.depth = 7;
  connection.deadline = milliseconds{20};
  connection.stale = model::Stale::error;
  const PlannedLink link = local(plan()).at(0);
  EXPECT_EQ(link.options.depth, 7U);
  EXPECT_TRUE(link.options.is_queue);
  EXPECT_EQ(link.options.deadline_ns, 20'000'000);
  EXPECT_EQ(link.stale, model::Stale::error);
}

TEST_F(PlannedWiring, WakesAModuleOnlyForEventsWithImmediateDispatch) {
  connect(end("here", "a", "out"), end("here", "p", "event"));
  connect(end("here", "a", "out"), end("here", "p", "in"));
  connect(end("here", "a", "out"), end("here", "b", "event"));
  auto links = local(plan());
  EXPECT_EQ(links.at(0).options.wake_bits, channel::wake_bit(3));
  EXPECT_EQ(links.at(1).options.wake_bits, 0U);
  EXPECT_EQ(links.at(2).options.wake_bits, 0U);
  cell.devices[0].modules[1].dispatch = model::Dispatch::immediate;
  EXPECT_EQ(local(plan()).at(2).options.wake_bits, channel::kSporadicBit);
}

TEST_F(PlannedWiring, SendsAnOutputToAllOtherDevicesThroughOneFlow) {
  auto& first = connect(end("here", "a", "out"), end("there", "x", "in"));
  first.deadline = milliseconds{30};
  first.lifespan = milliseconds{5};
  auto& second = connect(end("here", "a", "out"), end("there", "y", "in"));
  second.kind = model::ConnectionKind::queue;
  second.depth = 9;
  second.reliability = model::Reliability::reliable;
  second.deadline = milliseconds{10};
  second.lifespan = milliseconds{50};
  const WiringPlan plan = this->plan();
  EXPECT_TRUE(local(plan).empty());
  const PlannedFlow& flow = this->flow(plan, "takt/cell/here/a/out");
  ASSERT_EQ(flow.links.size(), 1U);
  EXPECT_TRUE(flow.connected);
  EXPECT_TRUE(flow.reliable);
  EXPECT_EQ(flow.depth, 9U);
  EXPECT_EQ(flow.deadline, Nanoseconds{milliseconds{10}});
  EXPECT_EQ(flow.lifespan, Nanoseconds{milliseconds{50}});
  const PlannedLink& link = plan.links[flow.links[0]];
  EXPECT_TRUE(link.options.enabled);
  EXPECT_EQ(link.options.depth, 9U);
  EXPECT_TRUE(link.options.is_queue);
}

TEST_F(PlannedWiring, PlansADeepQueueForObserversOfAnOutput) {
  const auto kept = [this] {
    const WiringPlan plan = this->plan();
    const PlannedFlow& flow = this->flow(plan, "takt/cell/here/a/out");
    EXPECT_FALSE(flow.connected);
    EXPECT_EQ(flow.depth, 1U) << "DDS itself needs no depth";
    return plan.links[flow.links.at(0)].options;
  };
  EXPECT_EQ(kept().depth, 64U);
  EXPECT_TRUE(kept().is_queue) << "so that samples that do not fit are counted";
  EXPECT_FALSE(kept().enabled);
  for (model::Port& port : *ports[0]) port.type.fields[0].dimensions = {1000};
  EXPECT_EQ(kept().depth, 2U) << "two samples of 8 kB in 16 kB";
}

TEST_F(PlannedWiring, SharesAFlowBetweenInputsWithTheSameQos) {
  connect(end("there", "x", "out"), end("here", "a", "in"));
  connect(end("there", "x", "out"), end("here", "b", "in"));
  connect(end("there", "x", "out"), end("here", "c", "in")).deadline = milliseconds{10};
  const WiringPlan plan = this->plan();
  std::vector<std::size_t> readers;
  for (const PlannedFlow& flow : plan.flows) {
    if (flow.outgoing) continue;
    EXPECT_EQ(flow.topic, "takt/cell/there/x/out");
    readers.push_back(flow.links.size());
  }
  EXPECT_EQ(readers, (std::vector<std::size_t>{2, 1}));
}

TEST_F(PlannedWiring, PlansASeparateFlowForAnExplicitTopic) {
  auto& out = connect(end("here", "a", "out"), {});
  out.topic = "rt/out";
  auto& in = connect({}, end("here", "b", "in"));
  in.topic = "rt/in";
  in.domain = 5;
  const WiringPlan plan = this->plan();
  EXPECT_TRUE(flow(plan, "rt/out").outgoing);
  EXPECT_TRUE(flow(plan, "rt/out").connected);
  EXPECT_FALSE(flow(plan, "takt/cell/here/a/out").connected);
  EXPECT_FALSE(flow(plan, "rt/in").outgoing);
  EXPECT_EQ(flow(plan, "rt/in").domain, 5);
}

TEST_F(PlannedWiring, DoesNotCountObserversAsConnections) {
  connect(end("here", "a", "out"), end("here", "b", "in"));
  auto& other = connect(end("here", "c", "out"), {});
  other.topic = "rt/out";
  auto wiring = Wiring::create(plan());
  ASSERT_TRUE(wiring.ok());
  const auto health_of = [&](std::uint32_t module, std::uint32_t readers) {
    return wiring->health(module, (*ports[module])[2], 0, [&](std::size_t) {
      wire::FlowHealth flow;
      flow.matched = readers;
      return std::optional{flow};
    });
  };
  // Enables all links, as observers that tap the links would.
  for (const Wiring::CreatedLink& created : wiring->links()) created.link.block().enabled.store(1);
  for (const std::uint32_t readers : {0U, 1U}) {
    EXPECT_EQ(health_of(0, readers).connections, 1U);
    EXPECT_EQ(health_of(0, readers).matched, 1U);
    EXPECT_EQ(health_of(1, readers).connections, 0U) << "the output has no connection";
    EXPECT_EQ(health_of(1, readers).matched, 0U);
    EXPECT_EQ(health_of(2, readers).connections, 1U) << "to an explicit topic";
    EXPECT_EQ(health_of(2, readers).matched, readers);
    EXPECT_EQ(health_of(2, readers).missing, 0U) << "other programs need not run";
  }
}

TEST_F(PlannedWiring, CountsEachConnectionOfReadersThatShareAFlow) {
  cell.devices.push_back({.name = "third", .executors = {{}}, .modules = {}});
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "a", "out"), end("there", "x", "in"));
  connect(end("here", "a", "out"), end("there", "y", "in"));
  connect(end("here", "a", "out"), end("third", "x", "in"));
  connect(end("here", "a", "out"), {}).topic = "rt/out";
  const auto wiring = Wiring::create(plan());
  ASSERT_TRUE(wiring.ok());
  const auto health_with = [&](std::uint32_t readers, std::uint32_t outside) {
    return wiring->health(0, (*ports[0])[2], 0, [&](std::size_t link) {
      const bool of_cell = wiring->links()[link].plan.connections.count("there") > 0;
      return std::optional{wire::FlowHealth{.matched = of_cell ? readers : outside, .incompatible = {}}};
    });
  };
  const std::vector<std::uint32_t> matched{health_with(0, 0).matched, health_with(1, 0).matched,
                                           health_with(2, 0).matched, health_with(2, 1).matched};
  EXPECT_EQ(matched, (std::vector<std::uint32_t>{1, 2, 4, 5}))
      << "both devices read, so all connections match";
  const std::vector<std::uint32_t> missing{health_with(0, 0).missing, health_with(1, 0).missing,
                                           health_with(2, 0).missing};
  EXPECT_EQ(missing, (std::vector<std::uint32_t>{3, 2, 0}));
  EXPECT_EQ(health_with(2, 0).connections, 5U);
}

TEST_F(PlannedWiring, CountsAConnectionToALostDeviceAsMissingAlthoughDdsStillMatchesIt) {
  cell.devices.push_back({.name = "third", .executors = {{}}, .modules = {}});
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "a", "out"), end("there", "x", "in"));
  connect(end("here", "a", "out"), end("there", "y", "in"));
  connect(end("here", "a", "out"), end("third", "x", "in"));
  connect(end("there", "x", "out"), end("here", "c", "in"));
  const auto wiring = Wiring::create(plan());
  ASSERT_TRUE(wiring.ok());
  const auto health_of = [&](std::uint32_t module, std::size_t port, const std::string& lost) {
    const PortHealth health = wiring->health(
        module, (*ports[module])[port], 0,
        [&](std::size_t link) {
          const std::uint32_t ends = wiring->links()[link].plan.from.module ? 2 : 1;
          return std::optional{wire::FlowHealth{.matched = ends, .incompatible = {}}};
        },
        [&](const std::string& device) { return device == lost; });
    return std::pair{health.matched, health.missing};
  };
  using Counts = std::pair<std::uint32_t, std::uint32_t>;
  EXPECT_EQ(health_of(0, 2, ""), (Counts{4, 0}));
  EXPECT_EQ(health_of(0, 2, "there"), (Counts{2, 2}));
  EXPECT_EQ(health_of(0, 2, "third"), (Counts{3, 1}));
  EXPECT_EQ(health_of(2, 0, ""), (Counts{1, 0}));
  EXPECT_EQ(health_of(2, 0, "there"), (Counts{0, 1})) << "an input";
}

TEST_F(PlannedWiring, NamesAConnectionWhoseOtherEndWasNotFound) {
  cell.devices.push_back({.name = "third", .executors = {{}}, .modules = {}});
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "a", "out"), end("there", "x", "in"));
  connect(end("here", "a", "out"), end("there", "y", "in"));
  connect(end("here", "a", "out"), end("third", "x", "in"));
  connect(end("third", "x", "out"), end("here", "c", "in"));
  connect(end("here", "c", "out"), {}).topic = "rt/out";
  const auto wiring = Wiring::create(plan());
  ASSERT_TRUE(wiring.ok());
  const auto unmatched = [&](std::uint32_t readers, std::uint32_t writers) {
    return wiring->unmatched([&](std::size_t link) -> std::optional<wire::FlowHealth> {
      const LinkEnd& from = wiring->links()[link].plan.from;
      if (from.port == "out" && from.module == 2U)
        return std::nullopt;  // no flow is open, nobody reads rt/out
      return wire::FlowHealth{.matched = from.module ? readers : writers, .incompatible = {}};
    });
  };
  EXPECT_EQ(unmatched(1, 1), "here.a.out -> there.x.in or here.a.out -> third.x.in");
  EXPECT_EQ(unmatched(2, 0), "third.x.out -> here.c.in");
  EXPECT_EQ(unmatched(2, 1), "");
}

TEST_F(PlannedWiring, CountsAConnectionToAMissingServiceAsUnmatched) {
  auto wiring = [&] {
    connect(end("here", "a", "out"), end("there", "x", "in")).carries = model::Carries::requests;
    return Wiring::create(plan());
  }();
  ASSERT_TRUE(wiring.ok());
  const PortHealth health =
      wiring->health(0, (*ports[0])[2], 0, [](std::size_t) { return std::optional{wire::FlowHealth{}}; });
  EXPECT_EQ(health.connections, 1U);
  EXPECT_EQ(health.matched, 0U);
  EXPECT_EQ(health.missing, 1U);
}

TEST_F(PlannedWiring, MakesALinkDeeperIfItsWriterMayRunAheadUnderLetTiming) {
  model::Device& here = cell.devices[0];
  here.executors[0].timing = model::Timing::let;
  for (model::Module& module : here.modules) {
    if (module.operation != model::Operation::periodic) continue;
    module.executor = here.executors[0].name;
    module.period = milliseconds{2};
  }
  here.modules[1].period = milliseconds{7};
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "b", "out"), end("here", "a", "in"));
  model::Connection& queue = connect(end("here", "a", "out"), end("here", "p", "event"));
  queue.kind = model::ConnectionKind::queue;
  queue.depth = 8;
  connect(end("here", "p", "out"), end("here", "a", "event"));
  const auto links = local(plan());
  ASSERT_EQ(links.size(), 4U);
  EXPECT_EQ(links[0].options.depth, 7U) << "b's period covers more than three of a's";
  EXPECT_EQ(links[1].options.depth, 4U);
  EXPECT_EQ(links[2].options.depth, 11U);
  EXPECT_EQ(links[3].options.depth, 1U) << "a sporadic module never writes ahead";
}

/// Module a provides a service with a handler. The clients of the service are module b and a module of device
/// "there".
TEST_F(PlannedWiring, PlansRequestAndReplyLinksOfAServiceInTheSameOrder) {
  const model::Type type{"t::T", {{.name = "x", .scalar = model::Scalar::float64}}};
  const auto add = [&](std::size_t module, Direction request, Direction reply, model::Role role) {
    ports[module]->push_back({"s/request", request, type, "", true, role});
    ports[module]->push_back({"s/reply", reply, type, "", true, role});
  };
  add(0, Direction::in, Direction::out, model::Role::handler);
  add(1, Direction::out, Direction::event, model::Role::client);
  cell.services = {{.client = end("there", "x", "s"), .server = end("here", "a", "s")},
                   {.client = end("here", "b", "s"), .server = end("here", "a", "s")},
                   {.client = end("here", "b", "s"), .server = end("there", "x", "s")}};
  model::connect_services(cell);
  const WiringPlan plan = this->plan();
  std::vector<LinkEnd> asked;
  std::vector<LinkEnd> answered;
  for (const PlannedLink& link : plan.links) {
    if (link.to == LinkEnd{0, "s/request"}) {
      asked.push_back(link.from);
      EXPECT_EQ(link.options.wake_bits, channel::kServiceBit);
      EXPECT_TRUE(link.options.is_queue);
    }
    if (link.from == LinkEnd{0, "s/reply"}) answered.push_back(link.to);
  }
  // The order of the links is: the client on the other device, the client on this device, and last any caller
  // from outside the cell.
  ASSERT_EQ(asked.size(), 3U);
  EXPECT_EQ(asked, (std::vector<LinkEnd>{{}, {1, "s/request"}, {}}));
  EXPECT_EQ(answered, (std::vector<LinkEnd>{{}, {1, "s/reply"}, {}}));

  const PlannedFlow& from_there = flow(plan, "takt/cell/there/x/s/request");
  EXPECT_TRUE(!from_there.outgoing && from_there.connected && from_there.reliable);
  const PlannedFlow& to_there = flow(plan, "takt/cell/there/x/s/reply");
  EXPECT_TRUE(to_there.outgoing && to_there.connected && to_there.reliable);
  EXPECT_EQ(to_there.carries, model::Carries::replies);
  const PlannedFlow& anybody = flow(plan, "takt/cell/here/a/s/request");
  EXPECT_TRUE(!anybody.outgoing && !anybody.connected && anybody.depth == 8);
  EXPECT_FALSE(flow(plan, "takt/cell/here/a/s/reply").connected);

  const PlannedFlow& asks_there = flow(plan, "takt/cell/here/b/s/request");
  EXPECT_TRUE(asks_there.outgoing && asks_there.connected);
  EXPECT_FALSE(plan.links.at(asks_there.links.at(0)).options.enabled) << "no service exists yet";
  const PlannedFlow& answers_here = flow(plan, "takt/cell/here/b/s/reply");
  EXPECT_FALSE(answers_here.outgoing);
}

TEST_F(PlannedWiring, PlansNoLinkForUnknownPorts) {
  ports[1].reset();
  connect(end("here", "a", "out"), end("here", "b", "in"));
  EXPECT_TRUE(local(plan()).empty());
}

TEST_F(PlannedWiring, GivesASafeValueOnlyToReadersOfTheLatestValue) {
  (*ports[0])[2].safe = R"({"x": 7})";
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "b", "out"), end("here", "c", "in"));
  connect(end("here", "a", "out"), end("here", "c", "event"));
  connect(end("here", "a", "out"), end("here", "p", "in")).kind = model::ConnectionKind::queue;
  const auto links = local(plan());
  ASSERT_EQ(links.size(), 4U);
  EXPECT_EQ(links[0].writer, end("here", "a", "out"));
  EXPECT_EQ(links[0].safe.size(), 12U);
  EXPECT_EQ(links[0].options.safe, 12U);
  EXPECT_TRUE(links[0].typed) << "although the safe value is stored as bytes";
  for (const std::size_t without : {1U, 2U, 3U}) {
    EXPECT_FALSE(links[without].writer.given()) << without;
    EXPECT_EQ(links[without].options.safe, 0U) << without;
  }
}

TEST_F(PlannedWiring, HasRoomForAForcedValueOnlyInLinksToInputsOfTheLatestValue) {
  connect(end("here", "a", "out"), end("here", "b", "in"));
  connect(end("here", "a", "out"), end("here", "b", "event"));
  connect(end("here", "a", "out"), end("here", "c", "in")).kind = model::ConnectionKind::queue;
  connect(end("there", "x", "out"), end("here", "p", "in"));
  const WiringPlan planned = plan();
  const auto links = local(planned);
  EXPECT_TRUE(links[0].typed);
  EXPECT_EQ(links[0].options.force, model::max_size((*ports[0])[0].type));
  EXPECT_EQ(links[1].options.force, 0U);
  EXPECT_EQ(links[2].options.force, 0U);
  const auto incoming = std::find_if(planned.links.begin(), planned.links.end(),
                                     [](const PlannedLink& link) { return !link.from.module; });
  ASSERT_NE(incoming, planned.links.end());
  EXPECT_GT(incoming->options.force, 0U);
}

TEST_F(PlannedWiring, PrefersTheSafeValueOfTheDescriptorToThatOfTheComponent) {
  (*ports[0])[2].safe = R"({"x": 7})";
  cell.devices[0].modules[0].safe = {{"out", {{"x", "2.5"}}}};
  cell.devices[0].modules[1].safe = {{"out", {}}};
  connect(end("here", "a", "out"), end("here", "c", "in"));
  connect(end("here", "b", "out"), end("here", "p", "in"));
  const auto links = local(plan());
  const model::Type& type = (*ports[0])[2].type;
  EXPECT_EQ(model::sample_json(type, links[0].safe.data(), links[0].safe.size()), R"({"x": 2.5})");
  EXPECT_EQ(model::sample_json(type, links[1].safe.data(), links[1].safe.size()), R"({"x": 0})");
}

TEST_F(PlannedWiring, AcceptsTheSafeValueOfAnotherDevicesOutputAfterItWasCreated) {
  connect(end("there", "x", "out"), end("here", "a", "in"));
  auto wiring = Wiring::create(plan());
  ASSERT_TRUE(wiring);
  const auto incoming =
      std::find_if(wiring->links().begin(), wiring->links().end(),
                   [](const Wiring::CreatedLink& created) { return created.plan.writer.given(); });
  ASSERT_NE(incoming, wiring->links().end());
  EXPECT_TRUE(incoming->link.safe().empty());
  EXPECT_TRUE(incoming->link.is_withheld());
  wiring->give_safe({end("there", "x", "other"), R"({"x": 1})"});
  EXPECT_TRUE(incoming->link.safe().empty());
  wiring->give_safe({end("there", "x", "out"), R"({"x": 1})"});
  EXPECT_EQ(incoming->link.safe().size(), 12U);
}

}  // namespace
}  // namespace takt::supervision::wiring_test
