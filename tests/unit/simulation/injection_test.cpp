#include <takt/simulation/injection.hpp>

#include <gmock/gmock.h>

#include <takt/simulation/random_cell.hpp>

namespace takt::simulation::injection_test {
namespace {

using std::chrono::milliseconds;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

void connect(model::Cell& cell, model::Endpoint from, model::Endpoint to) {
  model::Connection connection;
  connection.from = std::move(from);
  connection.to = std::move(to);
  cell.connections.push_back(connection);
}

model::Cell cell() {
  model::Cell cell;
  cell.name = "c";
  for (const char* name : {"robot", "line"}) {
    model::Device device;
    device.name = name;
    device.executors.emplace_back().name = "motion";
    for (const char* module : {"servo", "arm"}) {
      model::Module m;
      m.name = module;
      m.executor = "motion";
      m.period = milliseconds{1};
      device.modules.push_back(m);
    }
    cell.devices.push_back(device);
  }
  connect(cell, {"robot", "servo", "out"}, {"robot", "arm", "in"});
  connect(cell, {"robot", "arm", "state"}, {"line", "servo", "in"});
  connect(cell, {"robot", "arm", "state"}, {"line", "arm", "in"});
  return cell;
}

std::vector<Injection> read(const std::string& text) {
  const auto injections = parse_script(text, "script", cell());
  if (!injections) ADD_FAILURE() << to_text(injections.problems());
  return injections ? *injections : std::vector<Injection>{};
}

std::string error_of(const std::string& line) {
  const auto injections = parse_script("# first\n" + line + "\n", "script", cell());
  return injections ? "accepted" : to_text(injections.problems());
}

TEST(FaultScript, MayBeEmpty) {
  EXPECT_THAT(read(""), IsEmpty());
  EXPECT_THAT(read("\n  # nothing\n\n"), IsEmpty());
}

TEST(FaultScript, AcceptsEveryKindOfFault) {
  EXPECT_THAT(
      read("at 1.5 s robot.arm late 3 ms\n"
           "at 2s line.servo crash   # now\n"
           "at 0 ms robot.servo fail\n"
           "at 20 us robot.servo hang\r\n"
           "at 7 ns robot.servo unmended 2\n"
           "at 1 s robot.motion oversleep 300us\n"
           "at 3 s line clock-step -2 ms\n"
           "at 2 s link robot line cut for 0.5 s"),
      ElementsAre(
          Injection{
              .kind = Injection::Kind::late, .at = milliseconds{1500}, .target = 1, .by = milliseconds{3}},
          Injection{.kind = Injection::Kind::crash, .at = milliseconds{2000}, .device = 1},
          Injection{.kind = Injection::Kind::fail},
          Injection{.kind = Injection::Kind::hang, .at = Nanoseconds{20000}},
          Injection{.kind = Injection::Kind::unmended, .at = Nanoseconds{7}, .count = 2},
          Injection{.kind = Injection::Kind::oversleep, .at = milliseconds{1000}, .by = Nanoseconds{300000}},
          Injection{.kind = Injection::Kind::clock_step,
                    .at = milliseconds{3000},
                    .device = 1,
                    .by = -milliseconds{2}},
          Injection{
              .kind = Injection::Kind::cut, .at = milliseconds{2000}, .target = 1, .by = milliseconds{500}}));
}

TEST(FaultScript, AcceptsActionsOfTheOperatorAndFaultsOfNodes) {
  using Kind = Injection::Kind;
  const std::uint32_t the_operator = 2;  // the number of devices
  EXPECT_THAT(
      read("at 1 s update\n"
           "at 1 s undeploy # all devices\n"
           "at 1 s deploy\n"
           "at 1 s line down for 2 s\n"
           "at 1 s robot paused for 3 ms\n"
           "at 1 s line twin\n"
           "at 1 s operator down for 2 s\n"
           "at 1 s link operator line cut for 1 s"),
      ElementsAre(
          Injection{.kind = Kind::update, .at = milliseconds{1000}},
          Injection{.kind = Kind::undeploy, .at = milliseconds{1000}},
          Injection{.kind = Kind::deploy, .at = milliseconds{1000}},
          Injection{.kind = Kind::down, .at = milliseconds{1000}, .device = 1, .by = milliseconds{2000}},
          Injection{.kind = Kind::pause, .at = milliseconds{1000}, .by = milliseconds{3}},
          Injection{.kind = Kind::twin, .at = milliseconds{1000}, .device = 1},
          Injection{
              .kind = Kind::down, .at = milliseconds{1000}, .device = the_operator, .by = milliseconds{2000}},
          Injection{.kind = Kind::cut,
                    .at = milliseconds{1000},
                    .device = the_operator,
                    .target = 1,
                    .by = milliseconds{1000}}));
  for (const char* line : {"at 1 s operator fail", "at 1 s operator.arm fail", "at 1 s operator twin"})
    EXPECT_THAT(error_of(line), HasSubstr("the operator can only be down or paused")) << line;
  EXPECT_THAT(error_of("at 1 s update now"), HasSubstr("the line continues after the fault: 'now'"));
  EXPECT_THAT(error_of("at 1 s updat"), HasSubstr("there is no action 'updat'; did you mean update?"));
  EXPECT_THAT(error_of("at 1 s robot down"), HasSubstr("'for' is missing after 'down'"));
}

TEST(FaultScript, AppliesAFaultOfAnOutputToAllItsConnectionsToOtherDevices) {
  EXPECT_THAT(
      read("at 1 ms connection robot.arm.state lose 3"),
      ElementsAre(Injection{.kind = Injection::Kind::lose, .at = milliseconds{1}, .target = 1, .count = 3},
                  Injection{.kind = Injection::Kind::lose, .at = milliseconds{1}, .target = 2, .count = 3}));
}

TEST(FaultScript, ReportsEachMistakeWithItsLineAndAFix) {
  EXPECT_THAT(error_of("in 2 s robot crash"),
              AllOf(HasSubstr("script:2: error: "),
                    HasSubstr("; write, for example, at 1.5 s robot.servo late 3 ms")));
  for (const char* line :
       {"at soon robot.arm crash", "at -1 s robot.arm crash", "at 1e3 s robot.arm crash", "at"})
    EXPECT_THAT(error_of(line), HasSubstr("no time since T0")) << line;
  EXPECT_THAT(error_of("at 2 robot.arm crash"), HasSubstr("the time '2' after 'at' has no unit; write"));
  EXPECT_THAT(error_of("at 1 s robto.arm crash"), HasSubstr("no device 'robto'; did you mean robot?"));
  EXPECT_THAT(error_of("at 1 s robot.amr crash"),
              HasSubstr("device robot has no module 'amr'; did you mean arm?"));
  EXPECT_THAT(error_of("at 1 s robot.arm oversleep 1 ms"), HasSubstr("device robot has no executor 'arm'"));
  EXPECT_THAT(error_of("at 1 s robot.arm crahs"), HasSubstr("'crahs'; did you mean crash?"));
  EXPECT_THAT(error_of("at 1 s robot.arm"), HasSubstr("does not name a fault"));
  EXPECT_THAT(error_of("at 1 s robot crash"), HasSubstr("'crash'"));
  for (const char* line : {"at 1 s robot.arm late", "at 1 s robot.arm late 3", "at 1 s robot.arm late -3 ms",
                           "at 1 s robot.arm late 0 ms"})
    EXPECT_THAT(error_of(line), HasSubstr("no time after 'late'")) << line;
  for (const char* line :
       {"at 1 s robot.arm unmended", "at 1 s robot.arm unmended 0", "at 1 s robot.arm unmended x"})
    EXPECT_THAT(error_of(line), HasSubstr("no number above 0 after 'unmended'")) << line;
  EXPECT_THAT(error_of("at 1 s robot.arm crash 3"), HasSubstr("the line continues after the fault: '3'"));
  EXPECT_THAT(error_of("at 1 s link robot robot cut for 1 s"), HasSubstr("between two different devices"));
  EXPECT_THAT(error_of("at 1 s link robot line cut 1 s"), HasSubstr("'for' is missing after 'cut'"));
  EXPECT_THAT(error_of("at 1 s connection robot.servo.out lose 1"), HasSubstr("within its device"));
  EXPECT_THAT(error_of("at 1 s connection robot.arm.stat lose 1"),
              HasSubstr("did you mean robot.arm.state?"));
}

TEST(FaultScript, ReportsEveryMistakeAtOnce) {
  const auto injections = parse_script("at 1 s robot.arm crash\nx\ny\n", "script", cell());
  ASSERT_FALSE(injections.ok());
  EXPECT_THAT(injections.problems(), SizeIs(2));
}

// A trace shows each fault as a line of a script, so that users can copy the line into a script.
TEST(Injections, SurviveWritingToAScriptAndReadingBack) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const model::Cell random = random_cell(seed).cell;
    Draws draws{seed, "test"};
    for (const Injection& injection : draw_injections(random, draws, milliseconds{100}, 200)) {
      const std::string line = to_text(injection, random);
      const auto again = parse_script(line, "script", random);
      ASSERT_TRUE(again.ok()) << line << ": " << to_text(again.problems());
      EXPECT_THAT(*again, testing::Contains(injection)) << line;
    }
  }
}

TEST(Injections, AreDrawnAtTheRequestedRateInTimeOrder) {
  Draws draws{1, "test"};
  const auto injections = draw_injections(cell(), draws, milliseconds{2000}, 50);
  EXPECT_THAT(injections, SizeIs(100));
  EXPECT_TRUE(std::is_sorted(injections.begin(), injections.end(),
                             [](const Injection& a, const Injection& b) { return a.at < b.at; }));
  EXPECT_THAT(draw_injections(cell(), draws, milliseconds{2000}, 0), IsEmpty());
}

}  // namespace
}  // namespace takt::simulation::injection_test
