// One device of a simulated cell: the real supervision and the real executors, on virtual hosts, programs and
// flows. It stands for the processes of a machine: takt-host, libtakt_process and the gateway.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/core/result.hpp>
#include <takt/executor/executor.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/profile.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/simulation/event.hpp>
#include <takt/simulation/fault.hpp>
#include <takt/supervision/supervisor.hpp>
#include "invariants.hpp"
#include "kernel.hpp"
#include "run_time.hpp"
#include "wire.hpp"

namespace takt::simulation {

class Network;
class ThreadBody;
class VirtualHost;
class VirtualPlatform;
class VirtualProgram;

/// What the devices of a cell share. The referenced objects outlive the devices.
struct World {
  Kernel& kernel;
  Listener& listener;
  const model::Cell& cell;        ///< as simulated: see simulated_cell()
  const model::CellPorts& ports;  ///< the ports of every module
  const model::Profile& profile;
  std::uint64_t seed = 0;
  int cpus = 0;  ///< CPUs per device for executors that name no CPU; 0 for one per executor
  Network* network = nullptr;
  /// Called when a fault on this device stops the whole cell.
  std::function<void(std::uint32_t device, const std::string& why)> stop_cell{};
  /// Whether a module executes, as far as another device knows.
  std::function<bool(const std::string& device, const std::string& module)> executes{};
};

class Device {
 public:
  using Phase = supervision::Supervised::Phase;

  Device(const World& world, std::uint32_t index);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Loads, initialises and starts every module. This takes no time; then the device is ready.
  Result<void> prepare();
  void go(Instant t0) { supervisor_->go(t0); }
  /// Halts and destructs everything; the device ends some time later.
  void stop();
  /// Stops because of a fault of another device that stops the whole cell.
  void stop_for(Problem problem);
  [[nodiscard]] Phase phase() const noexcept { return supervisor_->phase(); }
  [[nodiscard]] const Problems& failures() const noexcept { return supervisor_->failures(); }
  /// Whether the module is in EXECUTING.
  [[nodiscard]] bool executes(const std::string& module) const;

  void inject(const Fault& fault);
  /// Delivers a sample for one of its modules; `wall_ns` is its time on the sender's wall clock.
  void arrive(Wire& wire, const std::byte* sample, std::int64_t wall_ns);

  /// The device's object in the status JSON.
  [[nodiscard]] nlohmann::ordered_json report() const;
  /// The device's counters, for the invariants.
  [[nodiscard]] Totals totals() const;

 private:
  friend class ThreadBody;
  friend class VirtualFlows;
  friend class VirtualHost;
  friend class VirtualPlatform;
  friend class VirtualProgram;
  struct Member;
  struct Row;

  // Set-up (device.cpp)
  void begin(supervision::Parts& parts);
  void make_wires();
  [[nodiscard]] std::unique_ptr<Row> make_row(std::uint32_t executor, VirtualHost& host,
                                              std::uint64_t generation);
  [[nodiscard]] executor::Unit unit_of(Member& member) const;
  /// `wanted` is the CPU that the descriptor names; without one, `index` selects it.
  Kernel::Place place_of(std::uint32_t executor, std::optional<int> wanted, std::size_t index, int below);
  Kernel::Place place_of(const Member& member);
  void command(std::uint32_t module, const Fault& fault);
  void step();
  void step_regularly();
  /// Lets the supervision react at once.
  void poke();
  [[nodiscard]] static std::uint64_t cycles(const Member& member);
  /// Whether hooks and starts of programs take time. Before T0, they take none.
  [[nodiscard]] bool takes_time() const { return phase() != Phase::preparing; }

  // Real-time strands (device_strands.cpp)
  void walk_rows(Row& row);
  void serve_sporadic(Row& row);
  void run_background(Member& member);
  void run_program(Member& member);
  bool await_release(Member& member, channel::Taken& taken);
  void emit_table_changes(std::uint32_t executor);
  void ring(std::uint32_t bits);
  void ring_pending() { ring(wake_word().take_pending()); }
  void forward_samples();
  void emit(What what, const Member& member);
  void emit(Event event, const Member& member);
  void emit(Event event);

  // A module's work, in run() or in the body of a program (device_work.cpp)
  void connect(Member& member);
  /// Does the work of a run or body that begins at `begin` for `release`.
  executor::Outcome work(Member& member, Instant release, Instant begin);
  const char* stale_input(Member& member, Instant start);
  template <class Input>
  [[nodiscard]] bool gets_safe_value(const Input& input) const;
  /// When the first available event may be read; channel::kNever if there is none.
  [[nodiscard]] std::int64_t news_at(const Member& member) const;

  [[nodiscard]] Instant now() const noexcept { return world_.kernel.now(); }
  [[nodiscard]] const model::Device& model() const { return world_.cell.devices[index_]; }
  [[nodiscard]] channel::WakeWord& wake_word() const { return parts_->wake_word[0]; }
  [[nodiscard]] std::int64_t wall_of(std::int64_t monotonic_ns) const noexcept {
    return monotonic_ns + wall_offset_.count();
  }

  const World& world_;
  std::uint32_t index_;
  Draws draws_;
  supervision::Parts* parts_ = nullptr;  // owned by the supervisor; null before prepare()
  std::unique_ptr<supervision::Supervisor> supervisor_;
  std::map<int, Cpu> shared_cpus_;  // shared CPUs, by number
  std::vector<std::unique_ptr<Member>> members_;
  std::vector<std::unique_ptr<Wire>> wires_;  // in the order of the wiring
  std::vector<Row*> rows_;                    // for each executor; its host owns the row
  Nanoseconds wall_offset_{};                 // wall clock minus monotonic clock
  bool gateway_awake_ = false;
  bool poked_ = false;
  bool stopped_cell_ = false;
};

}  // namespace takt::simulation
