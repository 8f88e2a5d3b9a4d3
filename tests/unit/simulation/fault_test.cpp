#include <takt/simulation/fault.hpp>

#include <gmock/gmock.h>

#include <takt/simulation/random_cell.hpp>

namespace takt::simulation::fault_test {
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

std::vector<Fault> read(const std::string& text) {
  const auto faults = parse_script(text, "script", cell());
  if (!faults) ADD_FAILURE() << to_text(faults.problems());
  return faults ? *faults : std::vector<Fault>{};
}

std::string error_of(const std::string& line) {
  const auto faults = parse_script("# first\n" + line + "\n", "script", cell());
  return faults ? "accepted" : to_text(faults.problems());
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
          Fault{.kind = Fault::Kind::late, .at = milliseconds{1500}, .place = 1, .by = milliseconds{3}},
          Fault{.kind = Fault::Kind::crash, .at = milliseconds{2000}, .device = 1},
          Fault{.kind = Fault::Kind::fail}, Fault{.kind = Fault::Kind::hang, .at = Nanoseconds{20000}},
          Fault{.kind = Fault::Kind::unmended, .at = Nanoseconds{7}, .count = 2},
          Fault{.kind = Fault::Kind::oversleep, .at = milliseconds{1000}, .by = Nanoseconds{300000}},
          Fault{
              .kind = Fault::Kind::clock_step, .at = milliseconds{3000}, .device = 1, .by = -milliseconds{2}},
          Fault{.kind = Fault::Kind::cut, .at = milliseconds{2000}, .place = 1, .by = milliseconds{500}}));
}

TEST(FaultScript, AppliesAFaultOfAnOutputToAllItsConnectionsToOtherDevices) {
  EXPECT_THAT(read("at 1 ms connection robot.arm.state lose 3"),
              ElementsAre(Fault{.kind = Fault::Kind::lose, .at = milliseconds{1}, .place = 1, .count = 3},
                          Fault{.kind = Fault::Kind::lose, .at = milliseconds{1}, .place = 2, .count = 3}));
}

TEST(FaultScript, ReportsEachMistakeWithItsLineAndAFix) {
  EXPECT_THAT(error_of("in 2 s robot crash"),
              AllOf(HasSubstr("script:2: error: "),
                    HasSubstr("; write, for example, at 1.5 s robot.servo late 3 ms")));
  for (const char* line : {"at soon robot.arm crash", "at 2 robot.arm crash", "at -1 s robot.arm crash",
                           "at 1e3 s robot.arm crash", "at"})
    EXPECT_THAT(error_of(line), HasSubstr("no time since T0")) << line;
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
  const auto faults = parse_script("at 1 s robot.arm crash\nx\ny\n", "script", cell());
  ASSERT_FALSE(faults.ok());
  EXPECT_THAT(faults.problems(), SizeIs(2));
}

// So users can copy a fault from a trace into a script.
TEST(Faults, SurviveWritingToAScriptAndReadingBack) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const model::Cell random = random_cell(seed).cell;
    Draws draws{seed, "test"};
    for (const Fault& fault : draw_faults(random, draws, milliseconds{100}, 200)) {
      const std::string line = to_text(fault, random);
      const auto again = parse_script(line, "script", random);
      ASSERT_TRUE(again.ok()) << line << ": " << to_text(again.problems());
      EXPECT_THAT(*again, testing::Contains(fault)) << line;
    }
  }
}

TEST(Faults, AreDrawnAtTheRequestedRateInTimeOrder) {
  Draws draws{1, "test"};
  const auto faults = draw_faults(cell(), draws, milliseconds{2000}, 50);
  EXPECT_THAT(faults, SizeIs(100));
  EXPECT_TRUE(std::is_sorted(faults.begin(), faults.end(),
                             [](const Fault& a, const Fault& b) { return a.at < b.at; }));
  EXPECT_THAT(draw_faults(cell(), draws, milliseconds{2000}, 0), IsEmpty());
}

}  // namespace
}  // namespace takt::simulation::fault_test
