// Tests the ports of modules on a real device.
#include <signal.h>

#include <set>

#include "real_device.hpp"

namespace takt::node::device_ports_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
namespace fs = std::filesystem;

class DevicePorts : public RealDevice {
 protected:
  static std::string source(const std::string& properties = "") {
    return module("source", "port_source.so", kEvery, properties);
  }
  static std::string slow_source() {
    return module("source", "port_source.so",
                  "<operationtype>periodic</operationtype><period>10000000</period>");
  }
  std::string sink(const std::string& name, const std::string& properties = "",
                   const std::string& more = "") const {
    return module(name, "port_sink.so", kEvery, file(name) + properties, more);
  }

  json port_of(const std::string& name, const std::string& port) const {
    const json module = module_of(name);
    for (const json& one : module["ports"]) {
      if (one["name"] == port) return one;
    }
    return {};
  }
  void wait_for_samples(const std::string& name, const std::string& port, int n) {
    ASSERT_TRUE(step_until([&] { return port_of(name, port)["samples"] > n; })) << module_of(name);
  }
  /// Expects that module `events` has not run more often than events arrived. A report during a run may
  /// count the run but not yet its event, so this function waits for a report between two runs.
  void expect_no_run_without_event() {
    EXPECT_TRUE(step_until([&] {
      return module_of("events")["cycles"].get<int>() <= port_of("events", "event")["samples"].get<int>();
    })) << module_of("events");
  }
  /// Expects that the module that logs its input to the file `name` has read every number from 1 on, and at
  /// least `least` numbers.
  void expect_all(const std::string& name, int least) const {
    SCOPED_TRACE(name);
    const json sink = seen(name);
    ASSERT_TRUE(sink.is_object());
    EXPECT_GE(sink["read"], least);
    EXPECT_EQ(sink["first"], 1);
    EXPECT_EQ(sink["wrong"], 0);
    EXPECT_EQ(sink["gaps"], 0);
  }
};

std::string connection(const std::string& from, const std::string& to, const std::string& what = "") {
  return "<connection from=\"d." + from + "\" to=\"d." + to + "\" " + what + "/>";
}

// ---- Values

TEST_F(DevicePorts, CarryValuesFromOneModuleToAnother) {
  bring_up(source() + sink("sink"), connection("source.out", "sink.in"));
  wait_for_samples("sink", "in", 250);
  take_down();
  expect_all("sink", 200);
  EXPECT_LT(seen("sink")["oldest_ns"], 1'000'000) << "both modules run in the same row";
}

TEST_F(DevicePorts, CarryValuesThroughProgramsAndCModules) {
  bring_up(source() + module("relay", "port_relay.exe", kEvery) +
               module("relay_c", "port_relay_c.so", kEvery) +
               module("program_c", "port_relay_c.exe", kEvery) + sink("sink"),
           connection("source.out", "relay.in", "kind=\"queue\" depth=\"64\"") +
               connection("relay.out", "relay_c.in", "kind=\"queue\" depth=\"64\"") +
               connection("relay_c.out", "program_c.in", "kind=\"queue\" depth=\"64\"") +
               connection("program_c.out", "sink.in", "kind=\"queue\" depth=\"64\""));
  wait_for_samples("sink", "in", 250);
  take_down();
  expect_all("sink", 200);
}

TEST_F(DevicePorts, DropTheOldestSamplesOfAFullQueue) {
  bring_up(source("<value name=\"burst\">10</value>") + sink("sink", "<value name=\"most\">3</value>"),
           connection("source.out", "sink.in", "kind=\"queue\" depth=\"7\""));
  wait_for_cycles("sink", 150);
  const json port = port_of("sink", "in");
  EXPECT_EQ(port["matched"], 1);
  EXPECT_GT(port["dropped"], 100);
  EXPECT_EQ(port["rating"], "poor");
  EXPECT_EQ(port["reason"], "degraded: drops samples");
  EXPECT_GT(port["samples"], 300);
  take_down();
  const json sink = seen("sink");
  EXPECT_GT(sink["read"], 300);
  EXPECT_EQ(sink["wrong"], 0);
  EXPECT_GE(sink["gaps"], sink["read"]) << "the sink reads only three of ten";
}

TEST_F(DevicePorts, GiveEachReaderAllSamples) {
  bring_up(source() + sink("one") + sink("two") + module("relay", "port_relay.exe", kEvery) + sink("three"),
           connection("source.out", "one.in", "kind=\"queue\" depth=\"9\"") +
               connection("source.out", "two.in") +
               connection("source.out", "relay.in", "kind=\"queue\" depth=\"99\"") +
               connection("relay.out", "three.in", "kind=\"queue\" depth=\"99\""));
  for (const char* name : {"one", "two", "three"}) wait_for_samples(name, "in", 250);
  take_down();
  for (const char* name : {"one", "two", "three"}) expect_all(name, 200);
}

TEST_F(DevicePorts, LetSeveralWritersShareAQueue) {
  bring_up(source() + module("other", "port_source.so", kEvery) + sink("sink"),
           connection("source.out", "sink.in", "kind=\"queue\" depth=\"9\"") +
               connection("other.out", "sink.in", "kind=\"queue\" depth=\"9\""));
  wait_for_samples("sink", "in", 400);
  EXPECT_EQ(port_of("sink", "in")["dropped"], 0);
  take_down();
}

TEST_F(DevicePorts, AreSeparateForTwoModulesOfTheSameCComponent) {
  bring_up(source() + module("first", "port_relay_c.so", kEvery) +
               module("second", "port_relay_c.so", kEvery) + module("third", "port_relay_c.so", kEvery) +
               sink("one") + sink("three"),
           connection("source.out", "first.in") + connection("source.out", "third.in") +
               connection("first.out", "one.in") + connection("third.out", "three.in"));
  for (const char* name : {"one", "three"}) wait_for_samples(name, "in", 150);
  EXPECT_EQ(port_of("second", "out")["samples"], 0);
  EXPECT_EQ(port_of("second", "in")["matched"], 0);
  take_down();
  expect_all("one", 100);
  expect_all("three", 100);
}

// ---- Events

TEST_F(DevicePorts, ReleaseASporadicModuleWhenAnEventArrives) {
  for (const std::string& dispatch : {kRow, kImmediate}) {
    bring_up(slow_source() + module("events", "port_events.so", kSporadic + dispatch, file("events")) +
                 sink("echo"),
             connection("source.out", "events.event", "kind=\"queue\" depth=\"8\"") +
                 connection("events.echo", "echo.in", "kind=\"queue\" depth=\"8\""));
    wait_for_samples("echo", "in", 40);
    expect_no_run_without_event();
    take_down();
    expect_all("events", 30);
    expect_all("echo", 30);
  }
}

TEST_F(DevicePorts, ReleaseASporadicProgramWhenAnEventArrives) {
  for (const std::string& dispatch : {kRow, kImmediate}) {
    bring_up(slow_source() + module("events", "port_events_program.exe", kSporadic + dispatch) + sink("echo"),
             connection("source.out", "events.event", "kind=\"queue\" depth=\"8\"") +
                 connection("events.echo", "echo.in", "kind=\"queue\" depth=\"8\""));
    wait_for_samples("echo", "in", 40);
    if (dispatch == kImmediate) expect_no_run_without_event();
    take_down();
    expect_all("echo", 30);
  }
}

TEST_F(DevicePorts, PassEventsAlongAChainOfSporadicModules) {
  bring_up(slow_source() + module("first", "port_events.so", kSporadic + kImmediate, file("first")) +
               module("second", "port_events_program.exe", kSporadic + kImmediate) +
               module("third", "port_events.so", kSporadic + kImmediate, file("third")),
           connection("source.out", "first.event", "kind=\"queue\" depth=\"8\"") +
               connection("first.echo", "second.event", "kind=\"queue\" depth=\"8\"") +
               connection("second.echo", "third.event", "kind=\"queue\" depth=\"8\""));
  wait_for_samples("third", "event", 40);
  take_down();
  expect_all("first", 30);
  expect_all("third", 30);
}

TEST_F(DevicePorts, ReleaseAProgramAtMostOncePerInterarrivalTime) {
  bring_up(source() + module("events", "port_events_program.exe",
                             kSporadic + kImmediate + "<interarrival>20000000</interarrival>"),
           connection("source.out", "events.event", "kind=\"queue\" depth=\"64\""));
  const Instant begin = os::now();
  wait_for_cycles("events", 10);
  const int cycles = module_of("events")["cycles"];
  EXPECT_LE(cycles, (os::now() - begin) / milliseconds{20} + 2);
  EXPECT_EQ(port_of("events", "event")["dropped"], 0) << "each body reads all waiting events";
  take_down();
}

// ---- Killed programs and hosts

TEST_F(DevicePorts, StillWorkAfterAProgramIsKilledRepeatedly) {
  bring_up(
      source() +
          module("relay", "port_relay.exe", kEvery, "", "<recovery attempts=\"100\" backoff=\"1000000\"/>") +
          sink("sink"),
      connection("source.out", "relay.in", "kind=\"queue\" depth=\"64\"") +
          connection("relay.out", "sink.in", "kind=\"queue\" depth=\"64\""));
  for (int i = 0; i < 10; ++i) {
    run_for(milliseconds{30 + i});
    ::kill(module_of("relay")["pid"], SIGKILL);
    const std::uint64_t before = port_of("sink", "in")["samples"];
    ASSERT_TRUE(step_until([&] { return port_of("sink", "in")["samples"] > before + 20; }))
        << "after kill " << i;
  }
  take_down();
  const json sink = seen("sink");
  EXPECT_EQ(sink["wrong"], 0);
  EXPECT_LE(sink["gaps"], 64 * 10) << "samples that the full queue dropped while no program read it";
}

TEST_F(DevicePorts, StillWorkAfterTheHostIsKilledRepeatedly) {
  // Each kill counts as a failure of the module that was running at that instant, so the modules need many
  // recovery attempts.
  const std::string recovery = "<recovery attempts=\"100\" backoff=\"1000000\"/>";
  bring_up(module("source", "port_source.so", kEvery, "", recovery) +
               module("relay", "port_relay.exe", kEvery) + sink("sink", "", recovery) +
               sink("typed", "", recovery),
           connection("source.out", "relay.in", "kind=\"queue\" depth=\"64\"") +
               connection("relay.out", "sink.in", "kind=\"queue\" depth=\"64\"") +
               connection("source.out", "typed.in", "kind=\"queue\" depth=\"1000\""));
  const auto counts = [&] {
    return std::array<std::uint64_t, 4>{module_of("sink")["cycles"], port_of("sink", "in")["samples"],
                                        module_of("typed")["cycles"], port_of("typed", "in")["samples"]};
  };
  for (int i = 0; i < 3; ++i) {
    run_for(milliseconds{60});
    const int program = module_of("relay")["pid"];
    ::kill(module_of("source")["pid"], SIGKILL);
    const auto before = counts();
    ASSERT_TRUE(step_until([&] {
      return std::ranges::equal(counts(), before, [](auto now, auto then) { return now > then + 20; });
    })) << "the counts continue after kill "
        << i;
    EXPECT_EQ(module_of("relay")["pid"], program);
  }
  take_down();
  EXPECT_EQ(seen("typed")["wrong"], 0);
  EXPECT_EQ(seen("typed")["first"], 1) << "counted since the restart of the source and the sink";
}

// ---- Stale inputs

TEST_F(DevicePorts, RaiseAnErrorForAStaleInputIfTheConnectionSaysSo) {
  const std::string deadline = "deadline=\"50000000\" stale=\"";
  const std::string recovery = "<recovery attempts=\"3\" backoff=\"1000000\"/>";
  bring_up(
      module("source", "port_relay.exe", kEvery, "", "<recovery attempts=\"3\" backoff=\"400000000\"/>") +
          module("first", "port_source.so", kEvery) + sink("strict", "", recovery) + sink("calm") +
          module("program", "port_relay.exe", kEvery, "", recovery),
      connection("first.out", "source.in") + connection("source.out", "strict.in", deadline + "error\"") +
          connection("source.out", "calm.in", deadline + "hold\"") +
          connection("source.out", "program.in", deadline + "error\""));
  run_for(milliseconds{200});
  EXPECT_EQ(module_of("strict")["state"], "EXECUTING");
  EXPECT_EQ(port_of("strict", "in")["late"], 0);
  ::kill(module_of("source")["pid"], SIGKILL);
  ASSERT_TRUE(step_until([&] { return module_of("strict")["state"] == "RECOVER"; }));
  ASSERT_TRUE(step_until([&] { return module_of("program")["state"] == "RECOVER"; }));
  EXPECT_EQ(module_of("calm")["state"], "EXECUTING");
  run_for(milliseconds{150});
  EXPECT_EQ(module_of("strict")["state"], "RECOVER") << "the module waits for its input";
  EXPECT_GT(port_of("calm", "in")["age_us"], 50'000.0);
  ASSERT_TRUE(step_until([&] { return module_of("strict")["state"] == "EXECUTING"; }));
  ASSERT_TRUE(step_until([&] { return module_of("program")["state"] == "EXECUTING"; }));
  for (const char* name : {"strict", "calm", "program"}) EXPECT_EQ(port_of(name, "in")["late"], 1) << name;
  for (const char* name : {"strict", "program"}) EXPECT_EQ(module_of(name)["errors"], 1) << name;
  EXPECT_EQ(module_of("calm")["errors"], 0);
  run_for(milliseconds{100});
  EXPECT_LT(port_of("strict", "in")["age_us"], 50'000.0);
  take_down();
  std::set<std::string> stale;
  for (const model::Fault& fault : faults) {
    if (fault.kind == model::FaultKind::stale_input) stale.insert(fault.module);
  }
  EXPECT_EQ(stale, (std::set<std::string>{"calm", "program", "strict"})) << "the writer has no stale input";
}

TEST_F(DevicePorts, TreatAnInputWithoutAValueAsStaleAfterItsDeadline) {
  bring_up(source("<value name=\"burst\">0</value>") + sink("sink"),
           connection("source.out", "sink.in", "deadline=\"100000000\" stale=\"error\""));
  run_for(milliseconds{80});
  EXPECT_EQ(module_of("sink")["state"], "EXECUTING") << "the deadline counts from the first release";
  ASSERT_TRUE(step_until([&] { return module_of("sink")["state"] == "RECOVER"; }));
  take_down();
}

// ---- Unconnected ports

TEST_F(DevicePorts, CarryNoSamplesWithoutAConnection) {
  bring_up(source() + sink("sink"), "");
  for (const char* name : {"source", "sink"}) wait_for_cycles(name, 50);
  EXPECT_EQ(port_of("source", "out")["matched"], 0);
  EXPECT_EQ(port_of("source", "out")["samples"], 0);
  EXPECT_EQ(port_of("sink", "in")["matched"], 0);
  EXPECT_TRUE(port_of("sink", "in")["age_us"].is_null());
  EXPECT_EQ(port_of("sink", "in")["type"], "samples::Count");
  take_down();
  EXPECT_EQ(seen("sink")["read"], 0);
}

}  // namespace
}  // namespace takt::node::device_ports_test
