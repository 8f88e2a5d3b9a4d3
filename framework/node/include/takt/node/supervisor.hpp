// Brings one device up, keeps it running, and takes it down.
//
// Only the node changes a module's state. It asks the host to call hooks, starts and ends programs, reads
// what the executors publish, and takes every step through the lifecycle's table. All of this happens on one
// thread that never waits: each call of step() reacts to what has happened and starts what is due.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/channel/channel.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/saved_state.hpp>
#include <takt/component.hpp>
#include <takt/core/result.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>
#include <takt/node/flight_recorder.hpp>
#include <takt/node/flow_manager.hpp>
#include <takt/node/hosted.hpp>
#include <takt/node/member.hpp>
#include <takt/node/retained.hpp>
#include <takt/node/supervised.hpp>
#include <takt/node/symbols.hpp>
#include <takt/node/violations.hpp>
#include <takt/node/wiring.hpp>
#include <takt/os/kernel_news.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>
#include <takt/schedule/placement.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::node {

class Supervisor final : public Supervised {
 public:
  struct Options {
    model::Cell cell;
    std::size_t device = 0;
    host::ComponentPaths paths;               ///< of the device's modules
    std::vector<model::ModulePorts> ports{};  ///< of the device's modules; empty: not known
    bool require_real_time = false;
    bool check_real_time = false;                ///< detect what real-time code must not do in modules
    os::WakeUps wake_ups{};                      ///< measured on this machine; a count of 0: not measured
    std::function<void(const Step&)> stepped{};  ///< called for every step of a module
    /// Called for every event of the fault record; `origin` names the source among several (port, executor).
    std::function<void(model::Fault, const std::string& origin)> noted{};
    /// Whether a module of another device is known to execute; none: never known.
    std::function<bool(const std::string& device, const std::string& module)> executes{};
    std::string state_folder{};                       ///< for what modules retain; empty: nothing is saved
    std::shared_ptr<dds::Participant> participant{};  ///< for samples of other devices; null: no DDS
    std::string traces{};  ///< how the names of the trace files of faults begin; empty: none is written
  };

  explicit Supervisor(Options options);
  ~Supervisor() override;

  Result<void> prepare() override;
  void go(Instant t0) override;
  void stop() override;
  void stop_for(Problem problem) override;
  void give_safe(const std::vector<model::SafeOutput>& outputs) override;
  void step() override;
  std::vector<const os::Fd*> wait_on() override;
  void command(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) override;
  Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant until) override;
  void trace(Nanoseconds last, std::size_t most,
             std::function<void(const Result<std::string>&)> done) override;
  Result<Tapped> open_service(std::uint32_t module, const model::Port& request, Instant until);
  void get(std::uint32_t module, const std::string& property,
           std::function<void(const Outcome&)> done) override;
  void set(std::uint32_t module, const std::string& property, const std::string& value,
           std::function<void(const Outcome&)> done) override;
  [[nodiscard]] Result<void> may_swap(std::uint32_t module) const override;
  void swap(std::uint32_t module, const std::string& path, std::function<void(const Outcome&)> done) override;

  [[nodiscard]] Phase phase() const noexcept override { return phase_; }
  [[nodiscard]] const Problems& failures() const noexcept override { return failures_; }
  [[nodiscard]] bool stops_cell() const noexcept override { return stops_cell_; }
  [[nodiscard]] Standing standing() const override;
  [[nodiscard]] nlohmann::ordered_json report() const override;
  [[nodiscard]] Measures measures() const override;

 private:
  // The hosts (supervisor_host.cpp)
  Result<void> start_host(Hosted& host);
  Hosted& host_of(const Member& member) const { return *hosts_[member.host]; }
  void ask(Member& member, channel::Doing hook, ErrorType type = ErrorType::none);
  void take_answers(Hosted& host);
  void answered(Member& member, channel::Doing hook, bool ok, const std::string& text);
  void begin_rows();
  void host_ended(Hosted& host, const os::ProcessEnd& end);
  void crashed(Member& member, const std::string& text, ErrorType type, std::optional<Instant> since,
               const std::string& callers, const std::string& core);
  void end_commands_of(const Hosted& host, const Member* culprit, const std::string& why);
  void restart_host(Hosted& host);
  void give_up_host(Hosted& host, const std::string& text);
  void watch_host(Hosted& host, Instant now);
  std::optional<Hang> never_halts(const Hosted& host) const;
  void bring_back(Member& member);

  // The machine (supervisor_machine.cpp)
  void watch_conditions();
  void watch_gaps();
  void report_violations();
  void fail_by_violations();

  // Programs (supervisor_process.cpp)
  Result<void> create_slot(Member& member);
  Result<void> spawn(Member& member);
  void watch_process(Member& member, Instant now);
  void watch_body(Member& member, Instant now);
  void process_ended(Member& member, const os::ProcessEnd& end);
  void process_ready(Member& member);
  void end_process(Member& member, Instant now);
  void forward_output();
  void wake(std::uint32_t bits);

  // Commands of an operator (supervisor_command.cpp)
  void begin_command(Member& member);
  void step_command(Member& member, Instant now);
  void end_command(Member& member, ReplyCode code, const std::string& text = {});
  /// Where the recovery of a module in RECOVER leads; empty in any other state.
  static std::string what_follows(const Member& member);

  // Swaps (supervisor_swap.cpp)
  void end_swap(Member& member, ReplyCode code, const std::string& text);
  void watch_swaps(Hosted& host, Instant now);
  /// Whether the new instance of a swap, and not the old one, ended the host.
  static bool by_swap(const Member& member, channel::Doing doing);

  // Inputs (supervisor_ports.cpp)
  void watch_inputs(Member& member, Instant now);
  static bool has_stale_input(const Member& member, Instant now);
  [[nodiscard]] PortHealth health_of(const Member& member, const model::Port& port, Instant now) const;
  // Safe values (supervisor_safe.cpp)
  /// Lets the module's outputs reach their readers on this device, or withholds them.
  void trust(const Member& member, bool trusted);
  void watch_writers();
  // Properties (supervisor_property.cpp)
  void ask_property(host::Request request, std::function<void(const Outcome&)> done);
  void property_answered(const host::Answer& answer);
  void fail_property_requests(const Hosted& host, const std::string& why);

  // The fault record (supervisor_faults.cpp)
  void note(model::FaultKind kind, const std::string& cause, const std::string& origin = {}) const;
  void note(const Member& member, model::FaultKind kind, const std::string& cause,
            ErrorType error = ErrorType::none, const std::string& attachment = {}) const;
  void note_counts(const Member& member, model::FaultKind kind, std::uint64_t& seen, std::uint64_t now,
                   const std::string& cause, const std::string& origin = {}) const;
  void watch_counts();
  void watch_ports(Instant now);
  void watch_port(Member& member, const model::Port& port, Instant now) const;
  /// From the dead host's crash report; both are empty if there is none.
  struct CrashCalls {
    std::string place;    ///< ", in F at file.cpp:1 in module.so"
    std::string callers;  ///< ", called by ...": for the fault record only
  };
  CrashCalls calls_of_crash(const channel::Crash& crash, const Member& culprit);

  // The flight record (supervisor_flight.cpp)
  Result<void> start_record();
  void record(const Member& member, const lifecycle::Transition& step, const std::string& text);

  // Lifecycle (supervisor.cpp)
  bool apply(Member& member, lifecycle::Event event, const std::string& text = {},
             ErrorType error = ErrorType::none);
  void log(const Member& member, const std::string& text) const;
  void log(const std::string& text) const;
  void fail_device(Problem problem);
  /// Reports an error of a module. `more` and `attachment` appear only in the fault record.
  void raise(Member& member, ErrorType type, const std::string& text,
             std::optional<Instant> since = std::nullopt, const std::string& more = {},
             const std::string& attachment = {});
  void lose(Member& member, const std::string& text, ErrorType type = ErrorType::failure,
            const std::string& more = {}, const std::string& attachment = {});
  void attempt_recovery(Member& member);
  void recovered(Member& member);
  void not_recovered(Member& member, const std::string& text);
  void give_up(Member& member);
  std::uint64_t cycles_of(const Member& member) const;
  static std::uint64_t releases_of(const Member& member);
  static std::uint64_t overruns_of(const Member& member);
  channel::Place place_of(const Member& member) const;
  void put_in_tables(Member& member);
  void take_from_tables(Member& member);
  /// Whether all runs that began before the module's removal from the tables have ended: rows, sporadic and
  /// background runs, and the body of its program. Only then may its hooks be called.
  bool is_out(const Member& member) const;
  void join_grid(Instant t0);
  Result<void> retain();
  void prepare_step();
  void running_step(Instant now);
  void stopping_step(Instant now);
  void destruct(Member& member, Instant now);
  const model::Device& device() const { return options_.cell.devices[options_.device]; }
  std::size_t executor_of(const Member& member) const;
  /// The module of a number from a host's memory; null if there is none. Foreign code can write any number
  /// there.
  Member* member_at(std::uint32_t index) const {
    return index < members_.size() ? members_[index].get() : nullptr;
  }
  channel::SavedState& saved_of(const Member& member) const {
    if (member.slot != nullptr) return member.slot->saved;
    return reinterpret_cast<channel::SavedState*>(saved_memory_.data())[member.index];
  }

  Options options_;
  Phase phase_ = Phase::preparing;
  Problems failures_;
  bool stops_cell_ = false;
  schedule::DevicePlan plan_;
  schedule::Placement placement_;
  bool real_time_ = true;
  std::optional<os::Throttling> throttling_;
  os::KernelNews kernel_news_;
  std::vector<std::int64_t> seen_latest_ns_;  // for each executor
  std::vector<bool> throttled_;               // for each executor: throttling was reported
  std::optional<Violations> violations_;      // only with check_real_time
  std::vector<std::uint64_t> seen_missed_;    // for each executor
  Instant ports_watched_at_{};
  std::optional<Symbols> symbols_;  // only after a crash
  channel::Channel channel_;
  std::unique_ptr<FlightRecorder> flight_;
  os::SharedMemory wake_word_memory_;
  channel::WakeWord* wake_word_ = nullptr;
  os::SharedMemory saved_memory_;  // what modules save; survives restarts of their hosts
  std::unique_ptr<Retained> retained_;
  Wiring wiring_;
  std::unique_ptr<FlowManager> flow_manager_;
  std::vector<std::unique_ptr<Member>> members_;
  std::vector<std::unique_ptr<Hosted>> hosts_;  // in the order of model::hosts_of()
  struct PropertyRequest {
    std::uint32_t module;
    std::function<void(const Outcome&)> done;
  };
  std::map<std::uint64_t, PropertyRequest> property_requests_;  // not yet answered by the host
  std::uint64_t property_requests_made_ = 0;
  std::map<std::pair<std::uint32_t, std::string>, std::uint32_t> matched_at_stop_;  // by module and port
  bool rows_begun_ = false;
  bool background_begun_ = false;
  std::uint32_t host_restarts_ = 0;
  std::optional<Instant> t0_;
  Instant asked_at_{};  // preparing: when it began; stopping: when the present step of it began
  bool end_asked_ = false;
};

}  // namespace takt::node
