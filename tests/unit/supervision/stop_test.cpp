// Tests how the supervision shuts a device down, with a host that does not react.
#include <takt/supervision/supervisor.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace takt::supervision::stop_test {
namespace {

using std::chrono::milliseconds;

/// A host that answers no request, and that still runs for a while after it was killed.
class SilentHost final : public Host {
 public:
  explicit SilentHost(int& kills) : kills_(kills) {}
  Result<void> start() override { return {}; }
  bool ask(const host::Request&) override { return true; }
  std::optional<host::Answer> answer() override { return std::nullopt; }
  std::optional<ProcessEnd> ended() override { return std::nullopt; }
  void kill() override { ++kills_; }
  void end_by(std::int32_t) override {}
  [[nodiscard]] bool running() const override { return true; }
  [[nodiscard]] int pid() const override { return 1; }
  CrashCalls calls_of_crash(std::uint32_t) override { return {}; }

 private:
  int& kills_;
};

class FakePlatform final : public Platform {
 public:
  [[nodiscard]] Instant now() const override { return time; }
  Result<void> begin(Parts& parts) override {
    parts.placement.executors.resize(parts.of_device().executors.size());
    return {};
  }
  [[nodiscard]] Nanoseconds spin_limit(const model::Module&, Nanoseconds) const override { return {}; }
  std::unique_ptr<Host> make_host(std::size_t) override { return std::make_unique<SilentHost>(kills); }
  std::unique_ptr<Program> make_program(std::uint32_t) override { return nullptr; }
  Result<std::unique_ptr<Flows>> open_flows() override { return std::unique_ptr<Flows>{}; }
  void wake(std::uint32_t) override {}
  [[nodiscard]] std::optional<Nanoseconds> ran_if_ready(std::int32_t) const override { return std::nullopt; }
  void step(Instant) override {}
  std::vector<Detection> detections() override { return {}; }
  void forget(std::uint32_t) override {}
  std::optional<Result<void>> forgotten(std::uint32_t) override { return Result<void>{}; }
  bool finish() override { return true; }
  Problems final_problems() override { return {}; }
  void add_to(nlohmann::ordered_json&) const override {}
  void log(const std::string&, const std::string& text) override { lines.push_back(text); }
  void stepped(const Step&) override {}
  void in_tables(std::uint32_t, bool) override {}
  void recovering(std::uint32_t, int) override {}
  void fault(const std::string&) override {}
  void host_died(const model::HostShare&) override {}
  void trace(Nanoseconds, std::size_t, std::function<void(const Result<std::string>&)>) override {}

  Instant time{std::chrono::seconds{1}};
  int kills = 0;
  std::vector<std::string> lines;
};

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
