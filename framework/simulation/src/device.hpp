// One device of a simulated cell: the real supervision and the real executors, on virtual hosts, programs and
// flows. This class replaces the processes of a real device: takt-host, process modules with libtakt_process,
// and the gateway.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/core/result.hpp>
#include <takt/executor/executor.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>
#include <takt/model/profile.hpp>
#include <takt/schedule/plan.hpp>
#include <takt/simulation/event.hpp>
#include <takt/simulation/injection.hpp>
#include <takt/supervision/supervisor.hpp>
#include "invariants.hpp"
#include "kernel.hpp"
#include "run_time.hpp"
#include "simulated_cell.hpp"
#include "simulated_link.hpp"

namespace takt::simulation {

class Network;
class Node;
class Operator;
class ThreadBody;
class VirtualHost;
class VirtualPlatform;
class VirtualProgram;

/// The objects and options that the devices of a cell share. The referenced objects outlive the devices.
struct World {
  Kernel& kernel;
  Listener& listener;
  const std::vector<SimulatedCell>& versions;  ///< the descriptors: the first one, and that of an update
  const model::Profile& profile;
  std::uint64_t seed = 0;
  Nanoseconds message_delay{};
  int cpus = 0;  ///< CPUs per device for executors that name no CPU; if 0, each of these executors has its
                 ///< own CPU
  Network* network = nullptr;
  /// The node of each device, and then the second nodes of devices. The index is the node's address.
  const std::vector<std::unique_ptr<Node>>* nodes = nullptr;
  Operator* operator_ = nullptr;

  [[nodiscard]] const model::Cell& cell() const { return versions.front().cell; }
};

class Device {
 public:
  using Phase = supervision::Supervised::Phase;

  /// `life` counts the devices that the node has had before.
  Device(const World& world, std::uint32_t index, Node& node, std::uint32_t life);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Returns the supervision of this device, which runs its modules. The device must outlive it, and uses it.
  [[nodiscard]] std::shared_ptr<supervision::Supervised> supervise(supervision::Supervisor::Options options);
  /// Kills all processes of the device. No supervision notices their end.
  void lose_power();
  [[nodiscard]] bool has_lost_power() const noexcept { return has_lost_power_; }
  [[nodiscard]] std::uint32_t version() const noexcept { return version_; }
  [[nodiscard]] Phase phase() const noexcept { return supervisor_->phase(); }
  [[nodiscard]] const Problems& failures() const noexcept { return supervisor_->failures(); }

  void inject(const Injection& injection);
  /// Delivers a sample to a module of this device; `wall_ns` is the sample's time on the sender's wall clock.
  void arrive(SimulatedLink& link, const std::byte* sample, std::int64_t wall_ns);

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
  void make_links();
  [[nodiscard]] std::unique_ptr<Row> make_row(std::uint32_t executor, VirtualHost& host,
                                              std::uint64_t generation);
  [[nodiscard]] executor::Unit unit_of(Member& member) const;
  /// `wanted` is the CPU that the descriptor names. If it names none, `index` selects the CPU.
  Kernel::Scheduling scheduling_of(std::uint32_t executor, std::optional<int> wanted, std::size_t index,
                                   int below);
  Kernel::Scheduling scheduling_of(const Member& member);
  void command(std::uint32_t module, const Injection& injection);
  /// Makes the supervision react now, before its next regular step.
  void poke();
  [[nodiscard]] static std::uint64_t cycles(const Member& member);
  /// True if hooks and starts of process modules take simulated time. They do not while the device is being
  /// prepared for the first time.
  [[nodiscard]] bool takes_time() const { return life_ != 0 || phase() != Phase::preparing; }

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

  // A module's work, in run() or in the body of a process module (device_work.cpp)
  void connect(Member& member);
  /// Does the work of a run or body that serves `release` and begins at `begin`.
  executor::Outcome work(Member& member, Instant release, Instant begin);
  const char* stale_input(Member& member, Instant start);
  template <class Input>
  [[nodiscard]] bool gets_safe_value(const Input& input) const;
  /// The time from which the module may read its first event; channel::kNever if there is no event.
  [[nodiscard]] std::int64_t news_at(const Member& member) const;

  [[nodiscard]] Instant now() const noexcept { return world_.kernel.now(); }
  [[nodiscard]] const model::Cell& cell() const { return world_.versions[version_].cell; }
  [[nodiscard]] const model::Device& model() const { return cell().devices[index_]; }
  /// Returns the number of the next sample of an output. No earlier device of this node has used it.
  [[nodiscard]] std::uint64_t number_of_next(const channel::LinkWriter& writer) const {
    return (std::uint64_t{life_} << 32) + writer.next();
  }
  [[nodiscard]] channel::WakeWord& wake_word() const { return parts_->wake_word[0]; }

  const World& world_;
  std::uint32_t index_;
  Draws draws_;
  supervision::Parts* parts_ = nullptr;  // owned by the supervisor; null before it begins
  Node& node_;
  const std::uint32_t life_;
  std::uint32_t version_ = 0;
  std::shared_ptr<supervision::Supervisor> supervisor_;
  bool began_ = false;
  bool has_lost_power_ = false;
  nlohmann::ordered_json last_report_{};
  std::map<int, Cpu> shared_cpus_;  // the CPUs that strands share, by number
  std::vector<std::unique_ptr<Member>> members_;
  std::vector<std::unique_ptr<SimulatedLink>> links_;  // the links of connections, in the order of the wiring
  std::vector<Row*> rows_;                             // the row of each executor; the executor's host owns
                                                       // it
  bool gateway_awake_ = false;
};

}  // namespace takt::simulation
