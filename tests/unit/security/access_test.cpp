#include <takt/security/access.hpp>

#include <gmock/gmock.h>

namespace access_test {
namespace {

using namespace takt;
using namespace takt::security;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

model::Endpoint at(const std::string& device, const std::string& port) { return {device, "m", port}; }

/// Returns a cell with three connections: from device robot to device line, from line to an external program,
/// and from an external program in domain 9 to robot.
model::Cell cell() {
  model::Cell cell;
  cell.name = "belt";
  cell.domain = 7;
  for (const char* name : {"robot", "line", "press"}) {
    cell.devices.emplace_back();
    cell.devices.back().name = name;
  }
  model::Connection between;
  between.from = at("robot", "out");
  between.to = at("line", "in");
  model::Connection outward;
  outward.from = at("line", "out");
  outward.topic = "speed";
  model::Connection inward;
  inward.to = at("robot", "in");
  inward.topic = "rt/goal";
  inward.domain = 9;
  cell.connections = {between, outward, inward};
  return cell;
}

Access on(const std::vector<Access>& all, int domain) {
  for (const Access& each : all) {
    if (each.domain == domain) return each;
  }
  return {};
}

std::vector<Access> of(Role role, const std::string& name) {
  return access_of(cell(), 7, {"belt", role, name});
}

TEST(AccessRights, AllowADeviceToWriteItsOwnTopicsAndThoseOfNodes) {
  EXPECT_THAT(on(of(Role::device, "robot"), 7).writes,
              ElementsAre("takt/belt/robot/*", "takt/belt/robot/m/out", "takt/device", "takt/executor",
                          "takt/fault", "takt/lifecycle", "takt/port", "takt/reply", "takt/statistics"));
}

TEST(AccessRights, AllowADeviceToReadItsConnectionsAndTheTopicsOfNodes) {
  EXPECT_THAT(on(of(Role::device, "line"), 7).reads,
              ElementsAre("takt/belt/line/*", "takt/belt/robot/m/out", "takt/command", "takt/device",
                          "takt/lifecycle", "takt/question"));
}

TEST(AccessRights, GiveADeviceWithoutConnectionsNoTopicsOfOtherDevices) {
  const Access press = on(of(Role::device, "press"), 7);
  EXPECT_THAT(press.reads, Not(Contains(HasSubstr("robot"))));
  EXPECT_THAT(press.writes, Not(Contains("speed")));
  EXPECT_THAT(on(of(Role::device, "line"), 7).writes, Contains("speed"));
}

TEST(AccessRights, IncludeTheOtherDomainsOfConnections) {
  EXPECT_THAT(on(of(Role::device, "robot"), 9).reads, ElementsAre("rt/goal"));
  EXPECT_THAT(on(of(Role::device, "robot"), 9).writes, IsEmpty());
  EXPECT_THAT(of(Role::device, "line"), testing::SizeIs(1));
  EXPECT_THAT(domains_of(cell(), 7), ElementsAre(7, 9));
}

TEST(AccessRights, AllowOnlyOperatorsToSendCommands) {
  EXPECT_THAT(on(of(Role::operator_, "anna"), 7).writes, Contains("takt/command"));
  for (const Role role : {Role::device, Role::observer, Role::program}) {
    for (const Access& each : of(role, "robot")) EXPECT_THAT(each.writes, Not(Contains("takt/command")));
  }
}

TEST(AccessRights, AllowAnObserverToReadEverythingAndWriteOnlyTheQuestionTopic) {
  EXPECT_THAT(on(of(Role::observer, "eve"), 7).reads, ElementsAre("*"));
  EXPECT_THAT(on(of(Role::observer, "eve"), 7).writes, ElementsAre("takt/question"));
}

TEST(AccessRights, AllowAnExternalProgramOnlyTheOpenEndsOfConnections) {
  EXPECT_THAT(on(of(Role::program, "hmi"), 7).reads, ElementsAre("speed"));
  EXPECT_THAT(on(of(Role::program, "hmi"), 7).writes, IsEmpty());
  EXPECT_THAT(on(of(Role::program, "hmi"), 9).writes, ElementsAre("rt/goal"));
}

TEST(AccessRights, LetAServiceUseTheRequestAndReplyTopicsOfItsClients) {
  model::Cell with = cell();
  model::Service service;
  service.client = at("line", "ask");
  service.server = at("robot", "serve");
  with.services = {service};
  model::connect_services(with);
  const Access robot = on(access_of(with, 7, {"belt", Role::device, "robot"}), 7);
  EXPECT_THAT(robot.reads, Contains("takt/belt/line/m/ask/request"));
  EXPECT_THAT(robot.writes, Contains("takt/belt/line/m/ask/reply"));
}

TEST(AccessRights, UseTheGivenDomainInsteadOfTheCellsDomain) {
  const auto robot = access_of(cell(), 40, {"belt", Role::device, "robot"});
  EXPECT_THAT(on(robot, 40).writes, Contains("takt/lifecycle"));
  EXPECT_THAT(on(robot, 7).writes, IsEmpty());
}

TEST(SecurityCheck, ReportsWhyACellCannotBeSecured) {
  EXPECT_THAT(obstacles(cell()), IsEmpty());
  model::Cell wrong = cell();
  wrong.discovery.kind = model::Discovery::Kind::server;
  wrong.connections[1].topic = "sp*";
  ASSERT_THAT(obstacles(wrong), testing::SizeIs(2));
  EXPECT_THAT(obstacles(wrong)[0].what, HasSubstr("discovery server"));
  EXPECT_THAT(obstacles(wrong)[1].what, HasSubstr("sp*"));
}

TEST(Subject, SurvivesARoundTrip) {
  for (const Role role : kRoles) {
    const Subject subject{"belt", role, "robot"};
    EXPECT_EQ(subject_from(to_text(subject)), subject);
  }
  EXPECT_EQ(to_text(Subject{"belt", Role::operator_, "anna"}), "CN=anna,OU=operator,O=belt");
  for (const char* wrong : {"", "CN=a", "CN=a,OU=king,O=belt", "CN=a b,OU=device,O=belt",
                            "CN=,OU=device,O=belt", "CN=a,OU=device,O=", "CN=a,OU=device,O=b,O=c"}) {
    EXPECT_FALSE(subject_from(wrong).has_value()) << wrong;
  }
}

TEST(PermissionsDocument, DeniesEverythingThatItDoesNotAllow) {
  const Subject robot{"belt", Role::device, "robot"};
  const std::string xml = permissions_xml(robot, {{7, {"a<b"}, {}}}, {0, 86400});
  EXPECT_THAT(xml, HasSubstr("<subject_name>CN=robot,OU=device,O=belt</subject_name>"));
  EXPECT_THAT(xml, HasSubstr("<not_before>1970-01-01T00:00:00</not_before><not_after>1970-01-02T00:00:00"));
  EXPECT_THAT(xml, HasSubstr("<topic>a&lt;b</topic>"));
  EXPECT_THAT(xml, HasSubstr("<default>DENY</default>"));
  EXPECT_THAT(xml, Not(HasSubstr("<subscribe>")));
  EXPECT_THAT(domains_in(xml), ElementsAre(7));
  EXPECT_THAT(domains_in(governance_xml({7, 9})), ElementsAre(7, 9));
  EXPECT_THAT(governance_xml({7}), HasSubstr("<allow_unauthenticated_participants>false<"));
}

}  // namespace
}  // namespace access_test
