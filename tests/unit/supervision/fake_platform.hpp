// A platform on virtual time, whose hosts and programs do nothing.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/supervision/parts.hpp>
#include <takt/supervision/platform.hpp>

namespace takt::supervision {

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

/// A program that counts how often it was killed, and still runs.
class FakeProgram final : public Program {
 public:
  explicit FakeProgram(int& kills) : kills_(kills) {}
  Result<void> start() override { return {}; }
  std::optional<ProcessEnd> ended() override { return std::nullopt; }
  void terminate() override {}
  void kill() override { ++kills_; }
  Result<void> make_real_time() override { return {}; }
  void wake_for_property() override {}
  [[nodiscard]] bool running() const override { return true; }
  [[nodiscard]] int pid() const override { return 2; }
  [[nodiscard]] std::string last_line() const override { return {}; }

 private:
  int& kills_;
};

class FakePlatform final : public Platform {
 public:
  [[nodiscard]] Instant now() const override { return time; }
  Result<void> begin(Parts& parts) override {
    parts.placement.executors.resize(parts.of_device().executors.size());
    parts.placement.background = {0};
    memory = &parts;
    return {};
  }
  [[nodiscard]] Nanoseconds spin_limit(const model::Module&, Nanoseconds) const override { return {}; }
  std::unique_ptr<Host> make_host(std::size_t) override { return std::make_unique<SilentHost>(kills); }
  std::unique_ptr<Program> make_program(std::uint32_t) override {
    return std::make_unique<FakeProgram>(kills);
  }
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
  int kills = 0;  ///< how often a host or a program was killed
  Parts* memory = nullptr;
  std::vector<std::string> lines;
};

}  // namespace takt::supervision
