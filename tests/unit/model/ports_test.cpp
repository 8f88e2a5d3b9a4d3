#include <takt/model/ports.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::ports_test {
namespace {

Field field(std::string name, Scalar scalar, std::vector<std::size_t> dimensions = {}) {
  Field field;
  field.name = std::move(name);
  field.scalar = scalar;
  field.dimensions = std::move(dimensions);
  return field;
}

Type joint(std::size_t axes = 6) { return {"motion::Joint", {field("position", Scalar::float64, {axes})}}; }
Type pick() { return {"motion::Pick", {field("number", Scalar::uint32)}}; }

class Connections : public testing::Test {
 protected:
  void SetUp() override {
    cell.name = "cell";
    cell.file = "cell.xml";
    for (const char* device : {"robot", "line"}) {
      Device d;
      d.name = device;
      for (const char* module : {"a", "b"}) {
        Module m;
        m.name = module;
        d.modules.push_back(m);
      }
      cell.devices.push_back(d);
    }
    const std::vector<Port> all{{"joint", Direction::in, joint(), ""},
                                {"moved", Direction::event, pick(), ""},
                                {"state", Direction::out, joint(), ""},
                                {"pick", Direction::out, pick(), ""}};
    ports = {{all, all}, {all, all}};
  }

  Problems check(Endpoint from, Endpoint to) {
    Connection connection;
    connection.from = std::move(from);
    connection.to = std::move(to);
    connection.line = 12;
    cell.connections = {connection};
    return check_connections(cell, ports);
  }
  static std::string text(const Problems& problems) { return to_text(problems); }

  Cell cell;
  CellPorts ports;
};

TEST_F(Connections, AcceptMatchingPorts) {
  EXPECT_EQ(check({"robot", "a", "state"}, {"line", "b", "joint"}), Problems{});
  EXPECT_EQ(check({"robot", "a", "pick"}, {"robot", "b", "moved"}), Problems{});
}

TEST_F(Connections, ThatAreMissingAreListedForEachModule) {
  ports[0][0]->push_back({"home/reply", Direction::in, pick(), "", false, Role::client});
  ports[0][0]->push_back({"ask/request", Direction::in, pick(), "", false, Role::service});
  ports[0][1].reset();  // the ports of this module are not known
  cell.devices[0].modules[0].line = 3;
  check({"robot", "a", "state"}, {"line", "b", "joint"});
  cell.connections.push_back(cell.connections[0]);
  cell.connections[1].to.port = "moved";
  const auto unconnected = unconnected_inputs(cell, ports);
  ASSERT_EQ(unconnected.size(), 2U);
  EXPECT_EQ(unconnected[0].module, "robot.a");
  EXPECT_EQ(unconnected[0].line, Line{3});
  EXPECT_THAT(unconnected[0].names, testing::ElementsAre("joint", "moved", "client home"));
  EXPECT_EQ(unconnected[1].module, "line.a");
  EXPECT_THAT(unconnected[1].names, testing::ElementsAre("joint", "moved"));
}

TEST_F(Connections, SuggestASimilarPortForAnUnknownName) {
  EXPECT_EQ(text(check({"robot", "a", "sate"}, {"line", "b", "joint"})),
            "cell.xml:12: error: module robot.a has no port 'sate'; did you mean state?");
  EXPECT_EQ(text(check({"robot", "a", "state"}, {"line", "b", "zzz"})),
            "cell.xml:12: error: module line.b has no port 'zzz'; use joint or moved");
}

TEST_F(Connections, ReportUnknownPortsAtBothEnds) {
  EXPECT_EQ(check({"robot", "a", "x"}, {"line", "b", "y"}).size(), 2U);
}

TEST_F(Connections, MustGoFromAnOutputToAnInput) {
  EXPECT_THAT(text(check({"robot", "a", "joint"}, {"line", "b", "joint"})),
              testing::StartsWith("cell.xml:12: error: port robot.a.joint is an input;"));
  EXPECT_THAT(text(check({"robot", "a", "state"}, {"line", "b", "pick"})),
              testing::StartsWith("cell.xml:12: error: port line.b.pick is an output;"));
}

TEST_F(Connections, WithSwappedFromAndToGetOnlyOneMessage) {
  EXPECT_EQ(
      text(check({"robot", "a", "joint"}, {"line", "b", "pick"})),
      "cell.xml:12: error: the connection goes from input robot.a.joint to output line.b.pick; a connection "
      "goes from an output to an input: swap 'from' and 'to'");
}

TEST_F(Connections, RejectPortsOfDifferentTypes) {
  EXPECT_EQ(text(check({"robot", "a", "state"}, {"line", "b", "moved"})),
            "cell.xml:12: error: port robot.a.state has type motion::Joint, but port line.b.moved has type "
            "motion::Pick; connect ports of the same type");
}

TEST_F(Connections, ReportTheFieldInWhichTwoVersionsOfATypeDiffer) {
  (*ports[1][1])[0].type = joint(7);
  EXPECT_THAT(text(check({"robot", "a", "state"}, {"line", "b", "joint"})),
              testing::HasSubstr("position is double[6] in the first version and double[7] in the second"));
}

TEST_F(Connections, AreNotCheckedIfTheModulesPortsAreUnknown) {
  ports[1][1].reset();
  EXPECT_EQ(check({"robot", "a", "state"}, {"line", "b", "anything"}), Problems{});
}

TEST_F(Connections, AreCheckedEvenIfOnlyOneEndIsInTheCell) {
  EXPECT_EQ(check({"robot", "a", "state"}, {}), Problems{});
  EXPECT_EQ(check({}, {"robot", "a", "state"}).size(), 1U);
}

TEST_F(Connections, ImmediateDispatchNeedsAConnectedEventPort) {
  cell.devices[0].modules[0].dispatch = Dispatch::immediate;
  cell.devices[0].modules[0].lines.dispatch = 5;
  EXPECT_EQ(check({"robot", "b", "pick"}, {"robot", "a", "moved"}), Problems{});
  EXPECT_THAT(
      text(check({"robot", "b", "state"}, {"robot", "a", "joint"})),
      testing::HasSubstr(
          "cell.xml:5: error: module a has <dispatch>immediate</dispatch>, but none of its event ports"));
  (*ports[0][0]).erase((*ports[0][0]).begin() + 1);
  EXPECT_THAT(text(check({"robot", "b", "state"}, {"robot", "a", "joint"})),
              testing::HasSubstr("no event port that could release it"));
}

TEST(PortsJson, SurvivesARoundTrip) {
  const std::vector<Port> ports{{"joint", Direction::in, joint(), "Where it is."},
                                {"moved", Direction::event, pick(), ""},
                                {"state", Direction::out, joint(), "\"quoted\"\n"}};
  const auto read = parse_ports(ports_json(ports));
  ASSERT_TRUE(read.ok());
  EXPECT_EQ(*read, ports);
}

TEST(PortsJson, RejectsTextThatIsNotAListOfPorts) {
  for (const char* text :
       {"", "[]", "{}", "{\"ports\": 5}", "{\"ports\": [5]}", "{\"ports\": [{\"name\": \"a\"}]}",
        "{\"ports\": [{\"name\": \"a\", \"direction\": \"up\", \"description\": \"{}\"}]}",
        "{\"ports\": [{\"name\": \"a\", \"direction\": \"in\", \"description\": \"{}\"}]}"}) {
    EXPECT_FALSE(parse_ports(text).ok()) << text;
  }
}

TEST(TypeDifference, NamesTheFirstDifferingField) {
  Type first = joint();
  EXPECT_EQ(difference(first, first), "");
  Type second = first;
  second.fields.push_back(field("time", Scalar::int64));
  EXPECT_EQ(difference(first, second), "time is only in the second version");
  EXPECT_EQ(difference(second, first), "time is only in the first version");
  second = first;
  second.fields[0].name = "angle";
  EXPECT_EQ(difference(first, second), "where the first version has position, the second has angle");
  second = first;
  second.fields[0].unit = "deg";
  EXPECT_EQ(difference(first, second),
            "position has no unit in the first version and the unit deg in the second");
  second = first;
  second.fields[0].scalar = Scalar::float32;
  EXPECT_EQ(difference(first, second),
            "position is double[6] in the first version and float[6] in the second");
}

/// A cell in which robot.a has the service "grip". The client "ask" of line.b has the same types as the
/// service; the clients of line.a and robot.b have other types.
class Services : public Connections {
 protected:
  static Type around(const char* suffix, const char* field, const Type& inner) {
    Field middle = ports_test::field(field, Scalar::structure);
    middle.type_name = inner.name;
    middle.fields = inner.fields;
    return {inner.name + suffix, {ports_test::field("client", Scalar::uint64), middle}};
  }
  void SetUp() override {
    Connections::SetUp();
    const auto add = [this](std::size_t device, std::size_t module, const std::string& name, Role role,
                            const Type& request, const Type& reply) {
      const bool client = role == Role::client;
      ports[device][module]->push_back({name + "/request", client ? Direction::out : Direction::in,
                                        around("_Request", "request", request), "", true, role});
      ports[device][module]->push_back({name + "/reply", client ? Direction::event : Direction::out,
                                        around("_Reply", "reply", reply), "", true, role});
    };
    add(0, 0, "grip", Role::handler, pick(), joint());
    add(1, 1, "ask", Role::client, pick(), joint());
    add(1, 0, "ask", Role::client, joint(), joint());
    add(0, 1, "ask", Role::client, pick(), joint(7));
  }
  std::string check_service(Endpoint client, Endpoint server) {
    cell.services = {{.client = std::move(client), .server = std::move(server), .line = 9}};
    cell.connections.clear();
    connect_services(cell);
    return text(check_connections(cell, ports));
  }
};

TEST_F(Services, AcceptAClientWithTheSameTypes) {
  EXPECT_EQ(check_service({"line", "b", "ask"}, {"robot", "a", "grip"}), "");
}

TEST_F(Services, NameTheTypesInWhichAClientDiffers) {
  EXPECT_EQ(check_service({"line", "a", "ask"}, {"robot", "a", "grip"}),
            "cell.xml:9: error: client line.a.ask has requests of type motion::Joint, but those of service "
            "robot.a.grip have type "
            "motion::Pick; connect a client and a service that have the same request and reply types");
  EXPECT_EQ(check_service({"robot", "b", "ask"}, {"robot", "a", "grip"}),
            "cell.xml:9: error: client robot.b.ask and service robot.a.grip have different versions of type "
            "motion::Joint: "
            "position is double[7] in the first version and double[6] in the second; build both components "
            "from the same "
            "IDL");
}

TEST_F(Services, RejectEndsThatAreNotAClientAndAService) {
  EXPECT_EQ(check_service({"line", "b", "ask"}, {"robot", "a", "gripp"}),
            "cell.xml:9: error: module robot.a has no service 'gripp'; did you mean grip?");
  EXPECT_EQ(
      check_service({"line", "b", "ask"}, {"robot", "a", "moved"}),
      "cell.xml:9: error: 'moved' of module robot.a is a port, not a service; connect it with <connection "
      "from=\"...\" to=\"...\"/>");
  EXPECT_EQ(
      check_service({"robot", "a", "grip"}, {"line", "b", "ask"}),
      "cell.xml:9: error: 'grip' of module robot.a is a service, not a client; client=\"...\" "
      "names the client and server=\"...\" names the service\n"
      "cell.xml:9: error: 'ask' of module line.b is a client, not a service; client=\"...\" names the client "
      "and server=\"...\" names the service");
}

TEST_F(Services, CannotBeUsedAsPortsOfAConnection) {
  EXPECT_EQ(text(check({"robot", "a", "state"}, {"robot", "a", "grip"})),
            "cell.xml:12: error: 'grip' of module robot.a is a service, not a port; connect it with <service "
            "client=\"...\" server=\"...\"/>");
  EXPECT_EQ(text(check({"robot", "a", "state"}, {"robot", "a", "grip/request"}))
                .find("cell.xml:12: error: 'grip' of module robot.a is a service"),
            0U);
}

TEST(PortsJson, KeepsTheRoleOfAPort) {
  std::vector<Port> all{{"s/request", Direction::in, pick(), "t", true, Role::handler},
                        {"p", Direction::out, pick(), "", false, Role::plain}};
  const auto again = parse_ports(ports_json(all));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(*again, all);
  EXPECT_EQ(name_of_service(all[0]), "s");
  EXPECT_EQ(name_of_service(all[1]), "p");
}

}  // namespace
}  // namespace takt::model::ports_test
