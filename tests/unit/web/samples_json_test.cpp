#include "web/samples_json.hpp"

#include <gmock/gmock.h>

#include "seen.hpp"

namespace takt::tool::web::said_test {
namespace {

using namespace seen;
using testing::HasSubstr;

TEST(StatusJson, ContainsTheStateAndMachineOfADevice) {
  const Json json = device_json(cell_that_runs()[0]);
  EXPECT_EQ(json["name"], "line");
  EXPECT_EQ(json["alive"], false);
  EXPECT_EQ(json["state"], "running") << "the last known state";
  EXPECT_EQ(json["machine"], "pc7");
  EXPECT_EQ(json["host_restarts"], 2);
}

TEST(StatusJson, ContainsTheOffsetOfAClockIfItIsKnown) {
  wire::ObservedDevice robot = device("robot");
  EXPECT_FALSE(device_json(robot).contains("clock_ms"));
  robot.status.clock_offset_ns(-2'600'000);
  robot.status.clock_error_ns(400'000);
  EXPECT_EQ(device_json(robot)["clock_ms"], (Json{{"offset", -3}, {"error", 1}}));
  robot.status.clock_error_ns(700'000);
  EXPECT_EQ(device_json(robot)["clock_ms"], (Json{{"offset", -3}, {"error", 2}})) << "-3.3 ms to -1.9 ms";
}

TEST(StatusJson, ContainsTheStateEventAndReasonOfATransition) {
  LifecycleStatus s = status("robot", "servo", STATE_RECOVER, 7);
  s.previous_state(STATE_EXECUTING);
  s.event(EVENT_ERROR);
  s.error(ERROR_BUDGET);
  wire::set(s.text(), "took \"long\"\n");
  s.time_ns(1'500'000);
  EXPECT_EQ(
      module_json(s).dump(),
      R"({"name":"robot.servo","state":"RECOVER","rating":"bad","previous":"EXECUTING","event":"error","error":"budget",)"
      R"("text":"took \"long\"\n","sequence":7,"time_ms":1.5})");
}

TEST(StatusJson, ContainsTheTablesAndGraphOfTheRunningCell) {
  const model::Cell press = cell();
  const Json json = cell_json(&press, 7, "d1");
  EXPECT_EQ(json["cell"], "press");
  EXPECT_EQ(json["domain"], 7);
  EXPECT_EQ(json["deployment"], "d1");
  const Json& robot = json["devices"][0];
  EXPECT_EQ(robot["executors"][0]["basic_period_ns"], 1'000'000);
  EXPECT_EQ(robot["executors"][0]["macro_period_ns"], 3'000'000);
  EXPECT_EQ(robot["executors"][0]["rows"].dump(), R"([["servo","slow"],["servo"],["servo"]])");
  EXPECT_EQ(robot["executors"][0]["sporadic"].dump(), R"(["react"])");
  EXPECT_FALSE(robot["executors"][0].contains("rows_left_out"));
  EXPECT_EQ(robot["modules"][0]["budget_ns"], 200'000);
  EXPECT_EQ(robot["modules"][2]["deadline_ns"], 2'000'000);
  EXPECT_FALSE(robot["modules"][2].contains("period_ns"));
  EXPECT_EQ(json["connections"][0]["deadline_ns"], 20'000'000);
  EXPECT_EQ(json["connections"][1]["to"], nullptr);
  EXPECT_THAT(json["graph"].get<std::string>(), HasSubstr("data-module=\"line.vision\""));
}

TEST(StatusJson, ContainsOnlyTheFirstRowsOfALongTable) {
  const model::Cell long_one = descriptor::parse(R"(<root>
        <module><filename>a.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
          <period>1000000</period><priority>1</priority></module>
        <module><filename>b.so</filename><moduletype>thread</moduletype><operationtype>periodic</operationtype>
          <period>1000000000</period><priority>1</priority></module></root>)",
                                                 "long.xml")
                                   .value();
  const Json json = cell_json(&long_one, 0, "d");
  EXPECT_EQ(json["devices"][0]["executors"][0]["rows"].size(), kMostRows);
  EXPECT_EQ(json["devices"][0]["executors"][0]["rows_left_out"], 1000 - kMostRows);
}

TEST(StatusJson, HasNoDevicesIfNoCellRuns) {
  const Json json = cell_json(nullptr, 3, "");
  EXPECT_EQ(json["cell"], nullptr);
  EXPECT_EQ(json["graph"], nullptr);
  EXPECT_TRUE(json["devices"].empty());
}

TEST(StatusJson, SaysThatAModuleIsInASafeStopIfItsOutputsReportIt) {
  auto devices = cell_that_runs();
  EXPECT_FALSE(measures_json(devices, nullptr, 0)["modules"]["robot.servo"].contains("safe_stop"));
  PortStatus& port = devices[1].deployment.ports.at("servo.angle").status;
  port.safe(true);
  EXPECT_FALSE(in_safe_stop(devices[1], "servo")) << "an input says that its reader gets the safe value";
  port.output(true);
  EXPECT_EQ(measures_json(devices, nullptr, 0)["modules"]["robot.servo"]["safe_stop"], true);
}

TEST(StatusJson, MarksForcedInputsAtTheModuleAndAtTheConnection) {
  auto devices = cell_that_runs();
  const model::Cell press = cell();
  EXPECT_FALSE(measures_json(devices, &press, 0)["modules"]["robot.servo"].contains("forced"));
  PortStatus& port = devices[1].deployment.ports.at("servo.angle").status;
  wire::set(port.port(), "angle");
  wire::set(port.forced(), "operator anna");
  const Json json = measures_json(devices, &press, 0);
  EXPECT_EQ(json["modules"]["robot.servo"]["forced"], "angle by operator anna");
  EXPECT_EQ(json["connections"]["1"]["rating"], "poor");
  EXPECT_EQ(json["connections"]["1"]["reason"], "forced: by operator anna");
}

TEST(StatusJson, DoesNotJudgeThePortsOfAModuleThatWaitsForItsFirstRelease) {
  auto devices = cell_that_runs();
  devices[0].alive = true;
  const model::Cell press = cell();
  LifecycleStatus& servo = devices[1].deployment.modules["servo"];
  servo = status("robot", "servo", STATE_START);
  servo.event(EVENT_START);
  EXPECT_FALSE(measures_json(devices, &press, 0)["connections"].contains("1"));
  servo.event(EVENT_STOP);
  EXPECT_TRUE(measures_json(devices, &press, 0)["connections"].contains("1")) << "an operator stopped it";
}

TEST(StatusJson, ContainsAllMeasurementsByName) {
  const model::Cell press = cell();
  const Json json = measures_json(cell_that_runs(), &press, 2'000'000);
  EXPECT_EQ(json["time_ms"], 2.0);
  EXPECT_EQ(json["modules"]["robot.servo"]["cycles"], 1000);
  EXPECT_EQ(json["modules"]["robot.servo"]["jitter_us"]["p999"], 60.5);
  EXPECT_EQ(json["executors"]["robot.main"]["missed"], 1);
  const Json& to_line = json["connections"]["0"];
  EXPECT_EQ(to_line["matched"], false) << "the line is lost";
  EXPECT_EQ(json["connections"]["1"]["matched"], true);
  EXPECT_EQ(to_line["stale"], true) << "30 ms is more than the deadline of 20 ms";
  EXPECT_EQ(to_line["rating"], "broken");
  EXPECT_EQ(to_line["reason"], "not matched");
  EXPECT_EQ(to_line["age_us"], 30'000.0);
  EXPECT_EQ(to_line["lost"], 4);
  EXPECT_EQ(json["connections"]["1"]["stale"], false) << "a topic for other programs has only a writer";
  EXPECT_TRUE(measures_json(cell_that_runs(), nullptr, 0)["connections"].empty()) << "the cell is not known";
}

TEST(StatusJson, RatesDevicesAndModules) {
  auto devices = cell_that_runs();
  EXPECT_EQ(device_json(devices[0])["rating"], "bad") << "the line is lost";
  EXPECT_EQ(device_json(devices[1])["rating"], "good");
  EXPECT_EQ(module_json(devices[1].deployment.modules.at("servo"))["rating"], "good");
  EXPECT_EQ(module_json(devices[1].deployment.modules.at("slow"))["rating"], "bad") << "in RECOVER";
  LifecycleStatus ended = status("robot", "servo", STATE_DESTRUCT);
  EXPECT_EQ(module_json(ended)["rating"], "idle");
  ended.event(EVENT_GIVE_UP);
  EXPECT_EQ(module_json(ended)["rating"], "bad");
}

TEST(StatusJson, RatesAConnectionAsPoorOnlyWhileItsQueueDropsSamples) {
  const model::Cell press = cell();
  auto devices = cell_that_runs();
  devices[0].alive = true;
  wire::ObservedPort& port = devices[0].deployment.ports.at("vision.angle");
  port.status.age_ns(1'000'000);
  const auto rating = [&](std::uint64_t dropped, std::int64_t seconds) {
    port.status.dropped(dropped);
    port.status.time_ns(seconds * 1'000'000'000);
    port.dropped.update(dropped, std::chrono::seconds{seconds});
    const Json one = measures_json(devices, &press, 0)["connections"]["0"];
    return one["rating"].get<std::string>() + ", " + one["reason"].get<std::string>();
  };
  EXPECT_EQ(rating(27756, 1), "good, ok") << "lost 4 samples before";
  EXPECT_EQ(rating(27757, 2), "poor, degraded: drops samples");
  EXPECT_EQ(rating(27757, 8), "good, ok");
}

TEST(StatusJson, DoesNotJudgeTheConnectionsOfADeviceThatDoesNotRun) {
  const model::Cell press = cell();
  auto devices = cell_that_runs();
  devices[0].alive = true;
  EXPECT_TRUE(measures_json(devices, &press, 0)["connections"].contains("0"));
  devices[0].status.state(DEVICE_ENDED);
  EXPECT_FALSE(measures_json(devices, &press, 0)["connections"].contains("0")) << "its values only grow old";
}

TEST(StatusJson, ReportsAConnectionToALostDeviceAsUnmatched) {
  for (const std::size_t lost : {0U, 1U}) {
    auto devices = cell_that_runs();
    devices[0].alive = devices[1].alive = true;
    EXPECT_TRUE(health_of(cell(), devices).connections.at(0).matched);
    devices[lost].alive = false;
    EXPECT_FALSE(health_of(cell(), devices).connections.at(0).matched);
  }
}

TEST(StatusJson, IgnoresDevicesOfAnotherCell) {
  auto devices = cell_that_runs();
  wire::set(devices[0].status.cell(), "other");
  const CellHealth health = health_of(cell(), devices);
  EXPECT_FALSE(health.devices.contains("line"));
  EXPECT_FALSE(health.connections.contains(0));
}

TEST(StatusJson, ContainsAllMembersOfAFault) {
  const Json json = fault_json({.sequence = 9,
                                .time_ns = 3'000'000,
                                .cell = "press",
                                .device = "robot",
                                .module = "servo",
                                .kind = model::FaultKind::error,
                                .error = "crash",
                                .cause = "signal 11",
                                .attachment = "/var/core",
                                .count = 2,
                                .cycle = 44});
  EXPECT_EQ(
      json.dump(),
      R"({"device":"robot","module":"servo","kind":"error","severity":"error","error":"crash",)"
      R"("cause":"signal 11","attachment":"/var/core","count":2,"cycle":44,"sequence":9,"time_ms":3.0})");
}

TEST(ShortText, ShowsTheFirstNumberAndHowManyValuesFollow) {
  using recording::Value;
  model::Type type{"t::T",
                   {{.name = "name", .scalar = model::Scalar::text, .bound = 8},
                    {.name = "x", .scalar = model::Scalar::float64},
                    {.name = "on", .scalar = model::Scalar::boolean}}};
  const auto text = [&type](const std::vector<Value>& values) {
    return short_text(recording::Columns{type}, values);
  };
  EXPECT_EQ(text({{"arm"}, {0.52359877559829}, {true}}), "0.5236 +2");
  EXPECT_EQ(text({{"arm"}, {-1234567.5}, {true}}), "-1.235e+06 +2");
  type.fields[1].unit = "rad";
  EXPECT_EQ(text({{"arm"}, {0.52359877559829}, {true}}), "0.5236 rad +2");
  type.fields.resize(1);
  EXPECT_EQ(text({{"arm"}}), "1 field");
  type.fields = {{.name = "on", .scalar = model::Scalar::boolean}};
  EXPECT_EQ(text({{false}}), "false");
  type.fields = {{.name = "n", .scalar = model::Scalar::int64}};
  EXPECT_EQ(text({{std::int64_t{12345678}}}), "12345678") << "short integers are exact";
  type.fields = {
      {.name = "mode", .scalar = model::Scalar::enumeration, .enumerators = {"IDLE", "POSITIONING"}}};
  EXPECT_EQ(text({{"POSITIONING", 1}}), "POSITION...");
}

}  // namespace
}  // namespace takt::tool::web::said_test
