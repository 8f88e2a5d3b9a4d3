// Starts one device, keeps it running, and shuts it down.
//
// Only the node changes a module's state. The supervisor asks the host to call hooks, starts and ends
// programs, reads the data that the executors publish, and takes every step through the lifecycle's table.
// All of this happens on one thread that never waits: each call of step() reacts to new events and starts
// actions that are due.
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
#include <takt/channel/removal.hpp>
#include <takt/component.hpp>
#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>
#include <takt/supervision/parts.hpp>
#include <takt/supervision/platform.hpp>
#include <takt/supervision/supervised.hpp>

namespace takt::supervision {

class FaultNotes;
class Forces;
class Health;
class Properties;
struct ExecutorWatch;
struct Hang;
struct Hosted;
struct Member;
class Watch;

class Supervisor final : public Supervised {
 public:
  struct Options {
    model::Cell cell;
    std::size_t device = 0;
    std::vector<std::string> paths;              ///< path of the component of each module
    std::vector<model::ModulePorts> ports{};     ///< the ports of each module; empty if they are not known
    bool require_real_time = false;              ///< true: the device does not start if the machine denies
                                                 ///< real time
    std::function<void(const Step&)> stepped{};  ///< called for every step of a module through its lifecycle
    /// Called for every event of the fault record. `origin` names the port or executor to which the event
    /// refers; it is empty if the event refers to neither.
    std::function<void(model::Fault, const std::string& origin)> noted{};
    /// Returns true if a module of another device is known to be in EXECUTING. If this function is empty, the
    /// supervisor treats every module of another device as not executing.
    std::function<bool(const std::string& device, const std::string& module)> executes{};
    /// Returns true if another device is known to be lost. If this function is empty, no device is.
    std::function<bool(const std::string& device)> is_lost{};
    /// Returns an upper bound of the wall clock of another device minus the monotonic clock of this device;
    /// nothing if no bound is known. If this function is empty, no bound is known for any device.
    std::function<std::optional<std::int64_t>(const std::string& device)> latest_clock{};
  };

  Supervisor(Options options, std::shared_ptr<Platform> platform);
  ~Supervisor() override;

  Result<void> prepare() override;
  void go(Instant t0) override;
  void stop() override;
  void stop_for(Problem problem) override;
  void give_safe(const std::vector<model::SafeOutput>& outputs) override;
  void step() override;
  void command(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) override;
  Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant until,
                     Nanoseconds every) override;
  Result<std::string> force(std::uint32_t module, const ForceRequest& request) override;
  Result<void> end_force(std::uint32_t module, const std::string& port, const std::string& who) override;
  void trace(Nanoseconds last, std::size_t most,
             std::function<void(const Result<std::string>&)> done) override;
  Result<Tapped> open_service(std::uint32_t module, const model::Port& request, Instant until);
  void get(std::uint32_t module, const std::string& property,
           std::function<void(const Outcome&)> done) override;
  void set(std::uint32_t module, const std::string& property, const std::string& value,
           std::function<void(const Outcome&)> done) override;
  [[nodiscard]] Result<void> may_swap(std::uint32_t module) const override;
  void swap(std::uint32_t module, const std::string& path, const std::map<std::string, std::string>& values,
            std::function<void(const Outcome&)> done) override;

  [[nodiscard]] std::string unmatched() const override;
  [[nodiscard]] Phase phase() const noexcept override { return phase_; }
  [[nodiscard]] const Problems& failures() const noexcept override { return failures_; }
  [[nodiscard]] bool stops_cell() const noexcept override { return stops_cell_; }
  [[nodiscard]] Standing standing() const override;
  [[nodiscard]] nlohmann::ordered_json report() const override;
  [[nodiscard]] Measures measures() const override;
  /// Returns the lifecycle state of a module, with its history.
  [[nodiscard]] const lifecycle::Machine& machine(std::uint32_t module) const;

 private:
  // Hosts (hosts.cpp)
  Hosted& host_of(const Member& member) const;
  void ask(Member& member, channel::Doing hook, ErrorType type = ErrorType::none);
  void take_answers(Hosted& host);
  void answered(Member& member, channel::Doing hook, bool ok, const std::string& text);
  void begin_rows();
  void host_ended(Hosted& host, const ProcessEnd& end);
  static CrashCalls calls_of(Hosted& host, const Member& culprit);
  void crashed(Member& member, const std::string& text, ErrorType type, std::optional<Instant> since,
               const std::string& callers, const std::string& core);
  void end_commands_of(const Hosted& host, const Member* culprit, const std::string& why);
  void restart_host(Hosted& host);
  void give_up_host(Hosted& host, const std::string& text);
  [[nodiscard]] Nanoseconds lasted(Instant since) const;
  void check_host(Hosted& host, Instant now);
  bool check_run(Hosted& host, const channel::Activity& activity, Watch& watch, Instant now);
  void check_rows(Hosted& host, Instant now);
  bool has_long_run(Instant now) const;
  std::optional<Nanoseconds> ran_if_starved(const Watch& watch, Nanoseconds limit, std::int32_t thread) const;
  [[nodiscard]] std::vector<const channel::Activity*> runs_of(const Hosted& host) const;
  [[nodiscard]] const channel::Activity* only_activity(const Hosted& host) const;
  std::optional<Hang> never_halts(const Hosted& host, Instant now) const;
  void bring_back(Member& member);

  void report_detections();

  // Programs (programs.cpp)
  void fill_slot(Member& member);
  Result<void> spawn(Member& member);
  void check_process(Member& member);
  void check_body(Member& member);
  void process_ended(Member& member, const ProcessEnd& end);
  void process_ready(Member& member);
  void end_process(Member& member, Instant now);

  // Commands of an operator (commands.cpp)
  void begin_command(Member& member);
  void step_command(Member& member, Instant now);
  void end_command(Member& member, ReplyCode code, const std::string& text = {});
  /// Returns a text that names the target state of a recovery; empty if the module is not in RECOVER.
  static std::string what_follows(const Member& member);
  std::string way_out(const Member& member) const;
  void keep_property(Member& member, const std::string& property, const std::string& value);

  // Swaps (swaps.cpp)
  void end_swap(Member& member, ReplyCode code, const std::string& text);
  void check_swaps(Hosted& host);
  /// True if the new instance of a swap, not the old instance, ended the host.
  static bool by_swap(const Member& member, channel::Doing doing);

  // Inputs (inputs.cpp)
  void check_inputs(Member& member, Instant now);
  static bool has_stale_input(const Member& member, Instant now);
  // Safe values (safe.cpp)
  /// If `trusted` is true, readers on this device get the samples of the module's outputs; otherwise the safe
  /// values.
  void trust(const Member& member, bool trusted);
  void check_writers();
  void pass_on_clocks();
  // Log lines (log.cpp)
  /// Begins to read the log of a module, if it has one, and sets its level as the descriptor says.
  void begin_log(Member& member, Instant now);
  void take_lines(Member& member, Instant now);
  /// Reads the level of a module's log (kLogLevelProperty), or sets it if `value` is not null.
  void log_level(const Member& member, const std::string* value,
                 const std::function<void(const Outcome&)>& done);
  // Properties (properties.cpp)
  void ask_property(host::Request request, std::function<void(const Outcome&)> done);
  void step_properties(Instant now);
  void property_answered(const host::Answer& answer);

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
  /// Moves a finished module one step closer to DESTRUCT. step() calls this until the module is there.
  void finish(Member& member, Instant now);
  void attempt_recovery(Member& member);
  void recovered(Member& member);
  void not_recovered(Member& member, const std::string& text);
  void give_up(Member& member);
  std::uint64_t cycles_of(const Member& member) const;
  Nanoseconds rows_every(const Member& member) const;
  void check_cycles(Member& member, Instant now);
  channel::ModuleMemory memory_of(const Member& member) const;
  void put_in_tables(Member& member);
  void take_from_tables(Member& member);
  /// True if all runs that began before the module's removal from the tables have ended: rows, sporadic and
  /// background runs, and the body of a process module. Only then may the module's hooks be called.
  bool is_out(const Member& member) const;
  void join_grid(Instant t0);
  void prepare_step();
  void running_step(Instant now);
  void stopping_step(Instant now);
  void destruct(Member& member, Instant now);
  const model::Device& device() const { return parts_.of_device(); }
  [[nodiscard]] Instant time() const { return platform_->now(); }
  std::size_t executor_of(const Member& member) const;
  /// The module with this index; null if there is none. The index comes from a host's memory, where foreign
  /// code can write any number.
  Member* member_at(std::uint32_t index) const {
    return index < members_.size() ? members_[index].get() : nullptr;
  }

  Options options_;
  Parts parts_;
  std::shared_ptr<Platform> platform_;
  Phase phase_ = Phase::preparing;
  Problems failures_;
  bool stops_cell_ = false;
  std::unique_ptr<Flows> flows_;
  std::vector<std::unique_ptr<Member>> members_;
  std::vector<std::unique_ptr<Hosted>> hosts_;  // the hosts, in the order of model::hosts_of()
  std::unique_ptr<FaultNotes> notes_;
  std::unique_ptr<Forces> forces_;
  std::unique_ptr<Health> health_;
  std::unique_ptr<Properties> properties_;
  bool rows_begun_ = false;
  bool background_begun_ = false;
  std::uint32_t host_restarts_ = 0;
  std::optional<Instant> t0_;
  std::vector<ExecutorWatch> watches_;  // one for each executor
  Instant stepped_at_{};                // when step() was called last
  Nanoseconds passed_{};                // time from the previous call of step() to the present one
  Instant moving_since_{};              // when the machine last continued after it had stood still
  Instant asked_at_{};                  // when preparing began, or when the present step of stopping began
  bool end_asked_ = false;
};

}  // namespace takt::supervision
