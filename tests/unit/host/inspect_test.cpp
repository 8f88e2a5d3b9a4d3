#include <takt/host/inspect.hpp>

#include <filesystem>
#include <fstream>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <folders.hpp>

#include <takt/core/log_level.hpp>
#include <takt/os/environment.hpp>

namespace takt::host::inspect_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

/// Returns a cell with two modules, and a connection from a port of the first module to a port of the second.
model::Cell cell_of(const std::string& first, const std::string& second) {
  model::Cell cell;
  cell.name = "cell";
  cell.file = "cell.xml";
  model::Device device;
  device.name = "line";
  for (const std::string& filename : {first, second}) {
    model::Module module;
    module.name = device.modules.empty() ? "first" : "second";
    module.filename = filename;
    module.line = device.modules.empty() ? 3 : 4;
    device.modules.push_back(module);
  }
  cell.devices.push_back(device);
  model::Connection connection;
  connection.from = {"line", "first", "out"};
  connection.to = {"line", "second", "in"};
  connection.line = 5;
  cell.connections.push_back(connection);
  return cell;
}

std::vector<std::string> problems_of(const model::Cell& cell) {
  std::vector<std::string> lines;
  const auto components = check_components(cell);
  if (components) return lines;
  for (const Problem& problem : components.problems()) lines.push_back(to_text(problem));
  return lines;
}

TEST(CheckComponents, ReportsNoPortProblemsForARejectedComponent) {
  const std::string plain = build_path("tests/objects/plain.so");
  EXPECT_THAT(problems_of(cell_of(plain, "no_such_file.so")),
              ElementsAre(StartsWith("cell.xml:3: error: module first: " + plain + " has no function run()"),
                          StartsWith("cell.xml:4: error: module second: there is no file no_such_file.so")));
}

TEST(MisnamedFiles, AreReportedIfAConnectionUsesTheNameOfTheExistingFile) {
  const std::string folder = testing::TempDir() + "takt-misnamed-" + std::to_string(os::process_id());
  std::filesystem::create_directories(folder);
  std::ofstream{folder + "/tank.so"} << "a component";
  model::Cell cell = cell_of("Tank.so", "valve.so");
  cell.file = folder + "/cell.xml";
  cell.devices[0].modules[0].name = "Tank";
  cell.devices[0].modules[1].name = "valve";
  cell.connections[0].from.module = "tank";
  cell.connections[0].to.module = "pump";  // not similar to valve
  const Problems problems = misnamed_files(cell);
  ASSERT_EQ(problems.size(), 1U);
  EXPECT_THAT(
      to_text(problems),
      AllOf(StartsWith(cell.file + ":3: error: module Tank: there is no file Tank.so (looked in " + folder),
            HasSubstr("; did you mean tank.so?")));
  cell.devices[0].modules[0].lines.name = 3;  // a <name> does not depend on the file
  EXPECT_EQ(misnamed_files(cell), Problems{});
  std::filesystem::remove_all(folder);
}

const std::string kPrograms = build_path("tests/components/");

TEST(ArgumentsOf, ReturnsTheArgumentsFollowedByThePropertiesWithoutTheLogLevel) {
  model::Module module;
  module.arguments = {"--camera", "0", "lens file.yaml", ""};
  module.properties = {{.name = "speed", .value = "2"},
                       {.name = kLogLevelProperty, .value = "debug"},
                       {.name = "a", .value = "b"}};
  EXPECT_THAT(arguments_of(module), ElementsAre("--camera", "0", "lens file.yaml", "", "speed=2", "a=b"));
}

class CheckPrograms : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kPrograms)) GTEST_SKIP() << "the sanitizer builds have no test programs";
  }
};

/// Returns a cell with one process module, made from the program `name`, and without connections.
model::Cell cell_of_program(const std::string& name, model::Operation operation) {
  model::Cell cell = cell_of(kPrograms + name, kPrograms + name);
  cell.connections.clear();
  cell.devices[0].modules.pop_back();
  cell.devices[0].modules[0].type = model::ModuleType::process;
  cell.devices[0].modules[0].operation = operation;
  return cell;
}

TEST_F(CheckPrograms, AcceptsAnUnconnectedProgramOfTheStatedOperationType) {
  EXPECT_THAT(problems_of(cell_of_program("fine.exe", model::Operation::periodic)), ElementsAre());
  EXPECT_THAT(problems_of(cell_of_program("fine_sporadic.exe", model::Operation::sporadic)), ElementsAre());
  EXPECT_THAT(problems_of(cell_of_program("ends.exe", model::Operation::non_real)), ElementsAre());
}

TEST_F(CheckPrograms, RejectsAnUnconnectedProgramOfAnotherOperationType) {
  EXPECT_THAT(problems_of(cell_of_program("fine_sporadic.exe", model::Operation::periodic)),
              ElementsAre("cell.xml:3: error: module first: the program calls initSporadicExe(), so it is "
                          "sporadic; use <operationtype>sporadic</operationtype> and <deadline>"));
  EXPECT_THAT(problems_of(cell_of_program("fine.exe", model::Operation::sporadic)),
              ElementsAre("cell.xml:3: error: module first: the program calls initPeriodExe(), so it is "
                          "periodic; use <operationtype>periodic</operationtype> and <period>"));
}

TEST_F(CheckPrograms, RejectsAProgramThatMakesItselfADaemon) {
  for (const char* how : {"daemon", "fork"}) {
    model::Cell cell = cell_of_program("misuses.exe", model::Operation::periodic);
    cell.devices[0].modules[0].arguments = {how};
    EXPECT_THAT(
        problems_of(cell),
        ElementsAre(StartsWith("cell.xml:3: error: module first: the program calls initPeriodExe() in a copy "
                               "of its process, which daemon() or fork() made; ")))
        << how;
  }
}

TEST_F(CheckPrograms, RejectsAPeriodicProgramThatIsNotLinkedWithTheProcessLibrary) {
  EXPECT_THAT(problems_of(cell_of_program("never_attaches.exe", model::Operation::periodic)),
              ElementsAre(StartsWith("cell.xml:3: error: module first: the program never calls "
                                     "initPeriodExe(), because it is not linked with libtakt_process")));
}

TEST_F(CheckPrograms, RejectsAProgramThatEndsBeforeItCallsAnInitFunction) {
  // Takt rejects a component if everybody may write to its folder. Everybody may write to /tmp, so the script
  // has its own folder there.
  const std::string folder = testing::TempDir() + "takt-inspect-" + std::to_string(os::process_id());
  std::filesystem::create_directories(folder);
  const std::string script = folder + "/ends_at_once.sh";
  std::ofstream{script} << "#!/bin/sh\nexit 3\n";
  std::filesystem::permissions(script, std::filesystem::perms::owner_all);
  model::Cell cell = cell_of_program("", model::Operation::sporadic);
  cell.devices[0].modules[0].filename = script;
  EXPECT_THAT(
      problems_of(cell),
      ElementsAre(AllOf(StartsWith("cell.xml:3: error: module first: "),
                        HasSubstr(" did not call initPeriodExe() or initSporadicExe() before it ended "
                                  "with status 3; call one of them"))));
  std::filesystem::remove_all(folder);
}

TEST_F(CheckPrograms, RejectsImmediateDispatchOfASporadicProgramWithoutAConnectedEventPort) {
  for (const auto& [name, reason] :
       {std::pair{"fine_sporadic.exe", "no event port that could release it"},
        std::pair{"port_events_program.exe", "none of its event ports is connected"}}) {
    model::Cell cell = cell_of_program(name, model::Operation::sporadic);
    cell.devices[0].modules[0].dispatch = model::Dispatch::immediate;
    cell.devices[0].modules[0].lines.dispatch = model::Line{7};
    EXPECT_THAT(problems_of(cell), ElementsAre(AllOf(StartsWith("cell.xml:7: error: "), HasSubstr(reason))))
        << name;
  }
}
}  // namespace
}  // namespace takt::host::inspect_test
