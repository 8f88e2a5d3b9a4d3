#include <takt/host/inspect.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::host::inspect_test {
namespace {

using testing::ElementsAre;
using testing::StartsWith;

/// Returns a cell of two modules, with a connection from a port of the first to a port of the second.
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
  EXPECT_THAT(problems_of(cell_of(TAKT_OBJECT_WITHOUT_RUN, "no_such_file.so")),
              ElementsAre(StartsWith("cell.xml:3: error: module first: " TAKT_OBJECT_WITHOUT_RUN
                                     " has no function run()"),
                          StartsWith("cell.xml:4: error: module second: there is no file no_such_file.so")));
}

}  // namespace
}  // namespace takt::host::inspect_test
