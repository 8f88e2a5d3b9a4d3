// One device of a simulated cell: its executors, thread modules, programs, links and their supervision. It
// stands for the node, the host and libtakt_process, and uses the same executor, lifecycle and channel.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/channel/channel.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/removal.hpp>
#include <takt/core/result.hpp>
#include <takt/executor/executor.hpp>
#include <takt/lifecycle/machine.hpp>
#include <takt/lifecycle/recovery.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/profile.hpp>
#include <takt/schedule/logical_time.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/simulation/event.hpp>
#include <takt/simulation/fault.hpp>
#include "invariants.hpp"
#include "kernel.hpp"
#include "run_time.hpp"
#include "wire.hpp"

namespace takt::simulation {

class Network;
class ThreadBody;

/// What the devices of a cell share. The referenced objects outlive the devices.
struct World {
  Kernel& kernel;
  Listener& listener;
  const model::Cell& cell;
  const std::vector<schedule::DevicePlan>& plans;
  const model::CellPorts& ports;
  const model::Profile& profile;
  std::uint64_t seed = 0;
  int cpus = 0;  ///< CPUs per device for executors that name none; 0: one for each executor
  Network* network = nullptr;
  /// A fault on this device stops the whole cell.
  std::function<void(std::uint32_t device, const std::string& why)> stop_cell{};
};

class Device {
 public:
  enum class Phase { preparing, ready, running, stopping, ended };

  Device(const World& world, std::uint32_t index);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Loads, initialises and starts every module. This takes no time; then the device is ready.
  Result<void> prepare();
  void go(Instant t0);
  /// Halts and destructs everything; the device ends some time later.
  void stop();
  /// Stops because of a fault of another device that stops the whole cell.
  void stop_for(Problem problem);
  [[nodiscard]] Phase phase() const noexcept { return phase_; }
  [[nodiscard]] const Problems& failures() const noexcept { return failures_; }

  void inject(const Fault& fault);
  /// Delivers a sample for one of its modules; `wall_ns` is its time on the sender's wall clock.
  void arrive(Wire& wire, const std::byte* sample, std::int64_t wall_ns);

  /// The device's object in the status JSON.
  [[nodiscard]] nlohmann::ordered_json report() const;
  /// The device's counters, for the invariants.
  [[nodiscard]] Totals totals() const;

 private:
  friend class ThreadBody;
  struct Member;
  struct Row;

  // Set-up (device.cpp)
  void make_members();
  void make_wires();
  void make_executors();
  [[nodiscard]] executor::Unit unit_of(Member& member) const;
  /// `wanted` is the CPU that the descriptor names; without one, `index` selects it.
  Kernel::Place place_of(std::uint32_t executor, std::optional<int> wanted, std::size_t index, int below);
  Kernel::Place place_of(const Member& member);

  [[nodiscard]] static std::uint64_t cycles(const Member& member);

  // Real-time strands (device_strands.cpp)
  void begin_strands();
  void walk_rows(Row& row);
  void serve_sporadic(Row& row);
  void run_background(Member& member);
  void run_program(Member& member);
  bool await_release(Member& member, channel::Taken& taken);
  void emit_table_changes(std::uint32_t executor);
  void ring(std::uint32_t bits);
  void ring_pending() { ring(wake_word_->take_pending()); }
  void forward_samples();
  [[noreturn]] void crash_host(Member& member);
  [[noreturn]] void leave(Member& member, const char* how);
  void end_host(std::optional<std::uint32_t> culprit, ErrorType type, const std::string& why);
  void emit(What what, const Member& member);
  void emit(Event event, const Member& member);
  void emit(Event event);

  // A module's work, in run() or in the body of a program (device_work.cpp)
  void connect(Member& member);
  /// Does the work of a run or body that begins at `begin` for `release`.
  executor::Outcome work(Member& member, Instant release, Instant begin);
  const char* stale_input(Member& member, Instant start);
  /// When the first available event may be read; channel::kNever if there is none.
  [[nodiscard]] std::int64_t news_at(const Member& member) const;

  // Supervision (device_supervision.cpp)
  void step();
  void supervise(Member& member);
  void watch_program(Member& member);
  void watch_inputs(Member& member);
  void watch_rows();
  bool apply(Member& member, lifecycle::Event event, const std::string& text = {},
             ErrorType error = ErrorType::none);
  void ask(Member& member, channel::Doing hook);
  void answered(Member& member, channel::Doing hook);
  void raise(Member& member, ErrorType type, const std::string& text,
             std::optional<Instant> since = std::nullopt);
  void lose(Member& member, const std::string& text, ErrorType type);
  void attempt_recovery(Member& member);
  void recovered(Member& member);
  void not_recovered(Member& member, const std::string& text);
  void give_up(Member& member);
  void fail_device(Problem problem);
  void host_is_seen_ended(std::optional<std::uint32_t> culprit, ErrorType type, const std::string& why);
  void start_host();
  void spawn(Member& member);
  void end_program(Member& member, bool killed, const std::string& why);
  void program_ended(Member& member, const std::string& text);
  void prepare_step();
  void stopping_step();
  void put_in_tables(Member& member);
  void take_from_tables(Member& member);
  [[nodiscard]] bool is_out(const Member& member) const;
  [[nodiscard]] std::uint64_t cycles_of(const Member& member) const;
  [[nodiscard]] channel::Place removal_of(const Member& member) const;

  [[nodiscard]] Instant now() const noexcept { return world_.kernel.now(); }
  [[nodiscard]] const model::Device& model() const { return world_.cell.devices[index_]; }
  [[nodiscard]] std::int64_t wall_of(std::int64_t monotonic_ns) const noexcept {
    return monotonic_ns + wall_offset_.count();
  }

  const World& world_;
  std::uint32_t index_;
  Phase phase_ = Phase::preparing;
  Problems failures_;
  Draws draws_;
  channel::Channel channel_;
  std::unique_ptr<channel::WakeWord> wake_word_;
  std::map<int, Cpu> shared_cpus_;  // shared CPUs, by number
  std::vector<std::unique_ptr<Member>> members_;
  std::vector<std::unique_ptr<Wire>> wires_;
  std::vector<std::unique_ptr<Row>> rows_;
  Nanoseconds wall_offset_{};  // wall clock minus monotonic clock

  Instant t0_{};
  bool rows_begun_ = false;
  bool host_runs_ = false;
  bool host_end_seen_ = true;
  std::uint64_t host_ = 0;  // counts hosts; requests to an earlier host get no answer
  Instant hooks_free_at_{};
  std::vector<Strand*> host_strands_;
  bool gateway_awake_ = false;
  bool halted_ = false;
  bool halt_asked_ = false;
  Instant asked_at_{};
};

}  // namespace takt::simulation
