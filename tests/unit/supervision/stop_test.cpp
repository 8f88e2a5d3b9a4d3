// Tests how the supervision shuts a device down, with a host that does not react.
#include <takt/supervision/supervisor.hpp>

#include <algorithm>
#include <memory>
#include <string>

#include <gmock/gmock.h>

#include "fake_platform.hpp"

namespace takt::supervision::stop_test {
namespace {

using std::chrono::milliseconds;

TEST(Shutdown, KillsAHostThatDoesNotHaltOnce) {
  model::Module module;
  module.name = "m";
  module.executor = "main";
  module.period = milliseconds{1};
  model::Cell cell;
  cell.name = "c";
  cell.devices = {{.name = "d", .executors = {{}}, .modules = {module}}};
  const auto platform = std::make_shared<FakePlatform>();
  Supervisor device{{.cell = cell, .paths = {"m.so"}, .ports = {std::nullopt}}, platform};
  ASSERT_TRUE(device.prepare().ok());
  device.stop();
  for (int i = 0; i < 30; ++i) {
    platform->time += milliseconds{100};
    device.step();
  }
  EXPECT_EQ(platform->kills, 1);
  EXPECT_EQ(std::count_if(platform->lines.begin(), platform->lines.end(),
                          [](const std::string& line) { return line.find("did not halt") != line.npos; }),
            1)
      << testing::PrintToString(platform->lines);
}

}  // namespace
}  // namespace takt::supervision::stop_test
