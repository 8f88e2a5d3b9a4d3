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
class Health;
class Properties;
struct Hang;
struct Hosted;
struct Member;

class Supervisor final : public Supervised {
 public:
  struct Options {
    model::Cell cell;
    std::size_t device = 0;
    std::vector<std::string> paths;              ///< the components of the device's modules
    std::vector<model::ModulePorts> ports{};     ///< the ports of each module; none if they are not known
    bool require_real_time = false;              ///< whether to fail if the machine does not allow real time
    std::function<void(const Step&)> stepped{};  ///< called for every step of a module
    /// Called for every event of the fault record; `origin` names the port or executor that the event is
    /// about; empty if it is about neither.
    std::function<void(model::Fault, const std::string& origin)> noted{};
    /// Whether a module of another device is known to execute. An empty function means that it never is.
    std::function<bool(const std::string& device, const std::string& module)> executes{};
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
  /// The lifecycle of a module.
  [[nodiscard]] const lifecycle::Machine& machine(std::uint32_t module) const;

 private:
  // Hosts (hosts.cpp)
  Hosted& host_of(const Member& member) const;
  void ask(Member& member, channel::Doing hook, ErrorType type = ErrorType::none);
  void take_answers(Hosted& host);
  void answered(Member& member, channel::Doing hook, bool ok, const std::string& text);
  void begin_rows();
  void host_ended(Hosted& host, const ProcessEnd& end);
  void crashed(Member& member, const std::string& text, ErrorType type, std::optional<Instant> since,
               const std::string& callers, const std::string& core);
  void end_commands_of(const Hosted& host, const Member* culprit, const std::string& why);
  void restart_host(Hosted& host);
  void give_up_host(Hosted& host, const std::string& text);
  void watch_host(Hosted& host, Instant now);
  std::optional<Hang> never_halts(const Hosted& host) const;
  void bring_back(Member& member);

  void report_detections();

  // Programs (programs.cpp)
  void fill_slot(Member& member);
  Result<void> spawn(Member& member);
  void watch_process(Member& member, Instant now);
  void watch_body(Member& member, Instant now);
  void process_ended(Member& member, const ProcessEnd& end);
  void process_ready(Member& member);
  void end_process(Member& member, Instant now);

  // Commands of an operator (commands.cpp)
  void begin_command(Member& member);
  void step_command(Member& member, Instant now);
  void end_command(Member& member, ReplyCode code, const std::string& text = {});
  /// Says to which state the recovery of a module in RECOVER leads; empty in any other state.
  static std::string what_follows(const Member& member);

  // Swaps (swaps.cpp)
  void end_swap(Member& member, ReplyCode code, const std::string& text);
  void watch_swaps(Hosted& host, Instant now);
  /// Whether the new instance of a swap, and not the old one, ended the host.
  static bool by_swap(const Member& member, channel::Doing doing);

  // Inputs (inputs.cpp)
  void watch_inputs(Member& member, Instant now);
  static bool has_stale_input(const Member& member, Instant now);
  // Safe values (safe.cpp)
  /// Lets the module's outputs reach their readers on this device, or withholds them.
  void trust(const Member& member, bool trusted);
  void watch_writers();
  // Properties (properties.cpp)
  void ask_property(host::Request request, std::function<void(const Outcome&)> done);
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
  void attempt_recovery(Member& member);
  void recovered(Member& member);
  void not_recovered(Member& member, const std::string& text);
  void give_up(Member& member);
  std::uint64_t cycles_of(const Member& member) const;
  channel::Place place_of(const Member& member) const;
  void put_in_tables(Member& member);
  void take_from_tables(Member& member);
  /// Whether all runs that began before the module's removal from the tables have ended: rows, sporadic and
  /// background runs, and the body of its program. Only then may its hooks be called.
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
  std::vector<std::unique_ptr<Hosted>> hosts_;  // in the order of model::hosts_of()
  std::unique_ptr<FaultNotes> notes_;
  std::unique_ptr<Health> health_;
  std::unique_ptr<Properties> properties_;
  bool rows_begun_ = false;
  bool background_begun_ = false;
  std::uint32_t host_restarts_ = 0;
  std::optional<Instant> t0_;
  Instant asked_at_{};  // when preparing began, or when the present step of stopping began
  bool end_asked_ = false;
};

}  // namespace takt::supervision
