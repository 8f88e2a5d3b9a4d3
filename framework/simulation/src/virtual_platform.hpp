// The platform of a simulated device, for its supervision: hosts and programs as strands, and the flows of
// the simulated network.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/supervision/platform.hpp>
#include "member.hpp"

namespace takt::simulation {

class VirtualHost final : public supervision::Host {
 public:
  VirtualHost(Device& device, std::size_t share) : device_(device), share_(share) {}

  Result<void> start() override;
  bool ask(const host::Request& request) override;
  std::optional<host::Answer> answer() override;
  std::optional<supervision::ProcessEnd> ended() override;
  void kill() override;
  void end_by(std::int32_t) override { kill(); }
  [[nodiscard]] bool running() const override { return alive_; }
  [[nodiscard]] int pid() const override { return 0; }
  supervision::CrashCalls calls_of_crash(std::uint32_t) override { return {}; }

  /// True if the strands of the host must end.
  [[nodiscard]] bool halting() const noexcept { return halting_; }
  [[nodiscard]] Instant t0() const;
  /// Called on a strand: ends the process, because the module's run() crashed.
  [[noreturn]] void crash(const Device::Member& member);

 private:
  [[nodiscard]] const model::HostShare& share() const { return device_.parts_->shares[share_]; }
  void perform(const host::Request& request);
  void call(const host::Request& request);
  /// Loads, initialises and starts the new instance of a module, while the old instance continues.
  void swap(const host::Request& request);
  void give_up(std::uint32_t module);
  /// Carries out the fault that is injected into this call of a hook. Returns false if there is none.
  bool meets_fault(const host::Request& request, channel::Doing hook, channel::Activity& activity);
  void reply(const host::Request& request, bool ok = true, std::string text = {});
  void begin_rows();
  void begin_background();
  void spawn(const Kernel::Scheduling& scheduling, Strand** kept, std::function<void()> body);
  void halt();
  void halted();
  void end_by_crash(const Device::Member& member, channel::Doing doing);
  /// Ends the process; the supervision notices the end a little later.
  void end(supervision::ProcessEnd end);

  Device& device_;
  const std::size_t share_;
  std::vector<std::unique_ptr<Device::Row>> rows_;
  std::vector<Strand*> strands_;
  std::size_t strands_running_ = 0;
  std::deque<host::Request> after_hang_;  // calls that wait because another hook does not return
  std::uint64_t generation_ = 0;          // number of processes that this host has had; a request to an
                                          // earlier process gets no answer
  bool alive_ = false;                    // true if the process runs, as far as the supervision knows
  bool runs_ = false;
  bool halting_ = false;
  std::optional<host::Request> halt_asked_;
  Instant free_at_{};  // the time from which the host can perform the next request
  std::deque<host::Answer> answers_;
  std::optional<supervision::ProcessEnd> end_;
};

class VirtualProgram final : public supervision::Program {
 public:
  VirtualProgram(Device& device, std::uint32_t module) : device_(device), module_(module) {}

  Result<void> start() override;
  std::optional<supervision::ProcessEnd> ended() override;
  void terminate() override;
  void kill() override;
  Result<void> make_real_time() override { return {}; }
  void wake_for_property() override {}  // virtual programs declare no properties
  [[nodiscard]] bool running() const override { return alive_; }
  [[nodiscard]] int pid() const override { return 0; }
  [[nodiscard]] std::string last_line() const override { return {}; }

  /// Called on the program's strand: the program ends itself.
  [[noreturn]] void leave(supervision::ProcessEnd end);

 private:
  [[nodiscard]] Device::Member& member() const { return *device_.members_[module_]; }
  void end(supervision::ProcessEnd end);

  Device& device_;
  const std::uint32_t module_;
  bool alive_ = false;  // true if the process runs, as far as the supervision knows
  std::optional<supervision::ProcessEnd> end_;
};

class VirtualPlatform final : public supervision::Platform {
 public:
  explicit VirtualPlatform(Device& device) : device_(device) {}

  [[nodiscard]] Instant now() const override { return device_.now(); }
  Result<void> begin(supervision::Parts& parts) override;
  [[nodiscard]] Nanoseconds spin_limit(const model::Module& module, Nanoseconds period) const override;
  std::unique_ptr<supervision::Host> make_host(std::size_t share) override;
  std::unique_ptr<supervision::Program> make_program(std::uint32_t module) override;
  Result<std::unique_ptr<supervision::Flows>> open_flows() override;
  void wake(std::uint32_t bits) override { device_.ring(bits); }
  [[nodiscard]] std::optional<Nanoseconds> ran_if_ready(std::int32_t thread) const override {
    return device_.world_.kernel.ran_if_ready(thread);
  }
  void step(Instant) override {}
  std::vector<supervision::Detection> detections() override { return {}; }
  void forget(std::uint32_t) override {}
  std::optional<Result<void>> forgotten(std::uint32_t) override { return Result<void>{}; }
  bool finish() override { return true; }
  Problems final_problems() override { return {}; }
  void add_to(nlohmann::ordered_json&) const override {}
  void log(const std::string&, const std::string&) override {}
  void stepped(const supervision::Step& step) override;
  void in_tables(std::uint32_t module, bool in) override;
  void recovering(std::uint32_t module, int attempt) override;
  void fault(const std::string&) override {}
  void host_died(const model::HostShare&) override {}
  void trace(Nanoseconds last, std::size_t most,
             std::function<void(const Result<std::string>&)> done) override;

 private:
  Device& device_;
};

}  // namespace takt::simulation
