#include <takt/model/safe.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::safe_test {
namespace {

/// A cell with module robot.servo, which has the output `effort` (fields torque and mode) and the input
/// `measured`.
class PortSafeValue : public testing::Test {
 protected:
  PortSafeValue() {
    cell.name = "cell";
    cell.file = "cell.xml";
    Device robot;
    robot.name = "robot";
    Module servo;
    servo.name = "servo";
    robot.modules.push_back(servo);
    cell.devices.push_back(robot);
    const Type type{"motion::Effort",
                    {{.name = "torque", .scalar = Scalar::float64, .dimensions = {2}},
                     {.name = "mode",
                      .scalar = Scalar::enumeration,
                      .type_name = "motion::Mode",
                      .enumerators = {"OFF", "HOLD"}}}};
    ports = {{ModulePorts{{{"effort", Direction::out, type, ""}, {"measured", Direction::in, type, ""}}}}};
  }
  Module& servo() { return cell.devices[0].modules[0]; }
  Port& effort() { return (*ports[0][0])[0]; }
  std::string value() { return read_safe(servo(), effort()).json; }
  std::string problems() { return to_text(check_connections(cell, ports)); }

  Cell cell;
  CellPorts ports;
};

TEST_F(PortSafeValue, IsEmptyIfNothingDefinesIt) {
  EXPECT_EQ(value(), "");
  EXPECT_TRUE(safe_bytes(servo(), effort()).empty());
  EXPECT_TRUE(safe_outputs(cell, ports).empty());
}

TEST_F(PortSafeValue, TakesTheFieldsThatTheDescriptorOmitsFromTheComponent) {
  effort().safe = R"({"torque":[1.0,2.0],"mode":"HOLD"})";
  EXPECT_EQ(value(), R"({"torque":[1.0,2.0],"mode":"HOLD"})");
  servo().safe = {{"effort", {{"torque", "[3, 4]"}}}};
  EXPECT_EQ(value(), R"({"torque": [3, 4], "mode": "HOLD"})");
}

TEST_F(PortSafeValue, IsZeroInUndefinedFields) {
  servo().safe = {{"effort", {}}};
  EXPECT_EQ(value(), R"({"torque": [0, 0], "mode": "OFF"})");
  servo().safe = {{"effort", {{"mode", "HOLD"}}}};
  EXPECT_EQ(value(), R"({"torque": [0, 0], "mode": "HOLD"})");
  EXPECT_EQ(problems(), "");
}

TEST_F(PortSafeValue, ReportsEachMistakeWithItsLine) {
  servo().safe = {
      {"effort", {{"torqe", "1", 7}, {"torque", "[1]", 8}, {"mode", "hold", 9}, {"mode", "OFF", 10}}, 6},
      {"measured", {}, 11},
      {"efort", {}, 12}};
  EXPECT_EQ(
      problems(),
      "cell.xml:7: error: the safe value of port 'effort': motion::Effort has no field 'torqe'; did you "
      "mean torque?\n"
      "cell.xml:8: error: the safe value of port 'effort': motion::Effort.torque cannot be a list of length "
      "1; "
      "write a list of length 2\n"
      "cell.xml:9: error: the safe value of port 'effort': motion::Effort.mode cannot be \"hold\"; did "
      "you mean HOLD?\n"
      "cell.xml:10: error: the safe value of port 'effort': motion::Effort.mode is given twice; give it "
      "one value\n"
      "cell.xml:11: error: port robot.servo.measured is an input and cannot have a safe value; use "
      "effort\n"
      "cell.xml:12: error: module robot.servo has no output 'efort'; did you mean effort?");
}

TEST_F(PortSafeValue, SurvivesARoundTripThroughJson) {
  servo().safe = {{"effort", {{"mode", "HOLD"}}}};
  const auto outputs = safe_outputs(cell, ports);
  ASSERT_EQ(outputs.size(), 1U);
  EXPECT_EQ(outputs[0].port, (Endpoint{"robot", "servo", "effort"}));
  EXPECT_EQ(parse_safe(safe_json(outputs)), outputs);
  EXPECT_TRUE(parse_safe("").empty());
  EXPECT_TRUE(parse_safe("[1]")[0].json.empty());
}

TEST_F(PortSafeValue, CanBeReadFromHexAndFromJson) {
  servo().safe = {{"effort", {{"mode", "HOLD"}}}};
  std::string hex;
  for (const std::byte byte : safe_bytes(servo(), effort())) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", std::to_integer<unsigned>(byte));
    hex += digits;
  }
  EXPECT_EQ(safe_of_hex(effort().type, hex), value());
  EXPECT_EQ(safe_of_hex(effort().type, "zz"), "");
  EXPECT_EQ(safe_of_hex(effort().type, hex.substr(2)), "");
  effort().safe = value();
  const auto again = parse_ports(ports_json(*ports[0][0]));
  ASSERT_TRUE(again);
  EXPECT_EQ(read_safe({}, (*again)[0]).json, R"({"torque":[0,0],"mode":"HOLD"})");
}

TEST_F(PortSafeValue, IsNotAllowedForQueuesEventsAndExternalWriters) {
  Connection connection;
  connection.from = {"robot", "servo", "effort"};
  connection.to = {"robot", "servo", "measured"};
  Port to = (*ports[0][0])[1];
  EXPECT_TRUE(may_be_safe(connection, to));
  to.direction = Direction::event;
  EXPECT_FALSE(may_be_safe(connection, to));
  to.direction = Direction::in;
  connection.kind = ConnectionKind::queue;
  EXPECT_FALSE(may_be_safe(connection, to));
  connection.kind = ConnectionKind::latest;
  connection.from = {};
  EXPECT_FALSE(may_be_safe(connection, to));
}

}  // namespace
}  // namespace takt::model::safe_test
