// A real device: its supervisor starts real hosts and process modules, but there is no node.
#pragma once

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <folders.hpp>
#include <long_enough.hpp>
#include <takt/descriptor/descriptor.hpp>
#include <takt/host/inspect.hpp>
#include <takt/node/device_platform.hpp>
#include <takt/node/log.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/signals.hpp>
#include <takt/supervision/supervisor.hpp>

namespace takt::node {

using supervision::Outcome;
using supervision::Step;
using supervision::Supervised;
using supervision::Supervisor;
using supervision::Verb;

class RealDevice : public testing::Test {
 protected:
  using json = nlohmann::json;
  using milliseconds = std::chrono::milliseconds;

  void SetUp() override {
    if (!std::filesystem::exists(kComponents + "/port_source.so"))
      GTEST_SKIP() << "the test's components are not built here";
    ::setenv("TAKT_COMPONENT_PATH", kComponents.c_str(), 1);
    folder = std::filesystem::temp_directory_path() / ("takt-device-" + std::to_string(::getpid()));
    std::filesystem::create_directory(folder);
    log_nothing();
  }
  void TearDown() override {
    if (!folder.empty()) std::filesystem::remove_all(folder);
  }

  static std::string module(const std::string& name, const std::string& file, const std::string& what,
                            const std::string& properties = "", const std::string& more = "") {
    const bool program = file.ends_with(".exe");
    return "<module><name>" + name + "</name><filename>" + file + "</filename><moduletype>" +
           (program ? "process" : "thread") + "</moduletype>" + what + "<priority>1</priority><property>" +
           properties + "</property>" + more + "</module>";
  }
  std::string file(const std::string& name) const {
    return "<value name=\"file\">" + (folder / name).string() + "</value>";
  }
  static inline const std::string kEvery = "<operationtype>periodic</operationtype><period>1000000</period>";
  static inline const std::string kSporadic =
      "<operationtype>sporadic</operationtype><deadline>10000000</deadline>";
  static inline const std::string kRow = "<dispatch>row</dispatch>";
  static inline const std::string kImmediate = "<dispatch>immediate</dispatch>";

  /// Starts device d, the only device of the cell, and waits until it is ready. If `start_rows` is true, also
  /// starts its rows.
  void bring_up(const std::string& modules, const std::string& connections = "", bool start_rows = true) {
    const std::string text =
        "<cell name=\"c\"><device name=\"d\">" + modules + "</device>" + connections + "</cell>";
    auto cell = descriptor::parse(text, "test.xml");
    ASSERT_TRUE(cell.ok()) << to_text(cell.problems());
    auto components = host::check_components(*cell);
    ASSERT_TRUE(components.ok()) << to_text(components.problems());
    platform = std::make_shared<DevicePlatform>(DevicePlatform::Options{});
    device = std::make_unique<Supervisor>(
        Supervisor::Options{
            .cell = *cell,
            .device = 0,
            .paths = components->paths[0],
            .ports = components->ports[0],
            .stepped = [this](const Step& step) { steps.push_back(step); },
            .noted = [this](const model::Fault& fault, const std::string&) { faults.push_back(fault); }},
        platform);
    const auto prepared = device->prepare();
    ASSERT_TRUE(prepared.ok()) << to_text(prepared.problems());
    ASSERT_TRUE(step_until([&] { return device->phase() == Supervisor::Phase::ready; })) << problems();
    if (start_rows) device->go(os::now() + milliseconds{20});
  }
  bool step_until(const std::function<bool()>& holds, milliseconds limit = long_enough()) {
    const Instant end = os::now() + limit;
    while (!holds()) {
      if (os::now() > end) return false;
      os::wait_readable(platform->wait_on(), 5);
      device->step();
    }
    return true;
  }
  void wait_for_cycles(const std::string& name, int n) {
    ASSERT_TRUE(step_until([&] { return module_of(name)["cycles"] > n; })) << module_of(name);
  }
  /// Waits until the module has run at least once from now on.
  void wait_for_run(const std::string& name) {
    wait_for_cycles(name, module_of(name)["cycles"].get<int>() + 1);  // a run may have begun before now
  }
  void run_for(milliseconds time) {
    step_until([] { return false; }, time);
  }
  void take_down() {
    device->stop();
    ASSERT_TRUE(step_until([&] { return device->phase() == Supervisor::Phase::ended; }));
    EXPECT_TRUE(device->failures().empty()) << problems();
  }
  std::string problems() const { return device->failures().empty() ? "" : to_text(device->failures()); }
  json module_of(const std::string& name) const {
    const json report = device->report();
    for (const json& one : report["modules"]) {
      if (one["name"] == name) return one;
    }
    return {};
  }
  json seen(const std::string& name) const {
    std::ifstream file{folder / name};
    std::stringstream text;
    text << file.rdbuf();
    return json::parse(text.str(), nullptr, false);
  }

  static inline const std::string kComponents = build_path("tests/components");
  std::filesystem::path folder;
  std::vector<model::Fault> faults;  ///< the events so far
  std::vector<Step> steps;           ///< the transitions of all modules so far
  std::shared_ptr<DevicePlatform> platform;
  std::unique_ptr<Supervisor> device;
};

}  // namespace takt::node
