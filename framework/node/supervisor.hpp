// Brings one device up, keeps it running, and takes it down.
//
// The node is the only one that changes a module's state: it asks the host to call hooks, starts and ends the
// programs, reads what the executors publish, and takes every step through the lifecycle's table. It does so
// in one thread that never waits for anybody: each call of step() looks at what has happened and starts what
// is due.
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
#include <takt/channel/seat.hpp>
#include <takt/component/component.hpp>
#include <takt/core/result.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>
#include <takt/node/gate.hpp>
#include <takt/node/host_link.hpp>
#include <takt/node/member.hpp>
#include <takt/node/supervised.hpp>
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
    std::vector<model::ModulePorts> ports{};  ///< the same; empty: nothing is known
    bool require_real_time = false;
    bool check_real_time = false;                     ///< what modules do that no real-time code may is seen
    os::WakeUps wake_ups{};                           ///< of this machine; none: they were not tried
    std::function<void(const Step&)> stepped{};       ///< told of every step of a module
    std::shared_ptr<dds::Participant> participant{};  ///< for samples of other devices; null: there are none
  };

  explicit Supervisor(Options options);
  ~Supervisor() override;

  Result<void> prepare() override;
  void go(Instant t0) override;
  void stop() override;
  void step() override;
  std::vector<const os::Fd*> wait_on() override;
  void order(std::uint32_t module, Verb verb, std::function<void(const Outcome&)> done) override;
  Result<Tapped> tap(std::uint32_t module, const std::string& port, Instant until) override;
  Result<Tapped> open_service(std::uint32_t module, const model::Port& request, Instant until);
  void get(std::uint32_t module, const std::string& property,
           std::function<void(const Outcome&)> done) override;
  void set(std::uint32_t module, const std::string& property, const std::string& value,
           std::function<void(const Outcome&)> done) override;

  [[nodiscard]] Phase phase() const noexcept override { return phase_; }
  [[nodiscard]] const Problems& failures() const noexcept override { return failures_; }
  [[nodiscard]] Standing standing() const override;
  [[nodiscard]] nlohmann::ordered_json report() const override;
  [[nodiscard]] Measures measures() const override;

 private:
  struct Hang {
    std::uint32_t module;
    channel::Doing doing;
    Nanoseconds limit;
  };

  // The host (supervisor_host.cpp)
  Result<void> start_host();
  void ask(Member& member, channel::Doing hook, ErrorType type = ErrorType::none);
  void take_answers();
  void answered(Member& member, channel::Doing hook, bool ok, const std::string& text);
  void begin_rows();
  void host_ended(const os::ProcessEnd& end);
  void watch_host(Instant now);
  std::optional<Hang> never_halts() const;
  void bring_back(Member& member);

  // The machine (supervisor_machine.cpp)
  void watch_conditions();
  void watch_gaps();
  void say_violations();
  void fail_by_violations();

  // Programs (supervisor_process.cpp)
  Result<void> create_seat(Member& member);
  Result<void> spawn(Member& member);
  void watch_process(Member& member, Instant now);
  void watch_body(Member& member, Instant now);
  void process_ended(Member& member, const os::ProcessEnd& end);
  void process_ready(Member& member);
  void end_process(Member& member, Instant now);
  void forward_output();
  void ring(std::uint32_t bits);

  // Orders of an operator (supervisor_command.cpp)
  void begin_order(Member& member);
  void order_step(Member& member, Instant now);
  void end_order(Member& member, ReplyCode code, const std::string& text = {});

  // Inputs (supervisor_ports.cpp)
  void watch_inputs(Member& member, Instant now);
  static bool has_stale_input(const Member& member, Instant now);
  [[nodiscard]] PortHealth health_of(const Member& member, const model::Port& port, Instant now) const;
  // Properties (supervisor_property.cpp)
  void ask_property(host::Request request, std::function<void(const Outcome&)> done);
  void property_answered(const host::Answer& answer);
  void nobody_answers(const std::string& why);

  // Lifecycle (supervisor.cpp)
  bool apply(Member& member, lifecycle::Event event, const std::string& text = {},
             ErrorType error = ErrorType::none);
  void log(const Member& member, const std::string& text) const;
  void log(const std::string& text) const;
  void fail_device(Problem problem);
  void raise(Member& member, ErrorType type, const std::string& text,
             std::optional<Instant> since = std::nullopt);
  void lose(Member& member, const std::string& text, ErrorType type = ErrorType::failure);
  void attempt_recovery(Member& member);
  void recovered(Member& member);
  void not_recovered(Member& member, const std::string& text);
  void give_up(Member& member);
  std::uint64_t cycles_of(const Member& member) const;
  channel::Place place_of(const Member& member) const;
  void put_in_tables(Member& member);
  void take_from_tables(Member& member);
  /// Whether nothing of it runs any more since it was taken from the tables: no row, sporadic run, background
  /// run or body of its program that began before. Its hooks may be called then.
  bool is_out(const Member& member) const;
  void join_grid(Instant t0);
  void prepare_step();
  void running_step(Instant now);
  void stopping_step(Instant now);
  void destruct(Member& member, Instant now);
  const model::Device& device() const { return options_.cell.devices[options_.device]; }
  std::size_t executor_of(const Member& member) const;

  Options options_;
  Phase phase_ = Phase::preparing;
  Problems failures_;
  schedule::DevicePlan plan_;
  schedule::Placement placement_;
  bool real_time_ = true;
  std::optional<os::Throttling> throttling_;
  os::KernelNews kernel_news_;
  std::vector<std::int64_t> seen_latest_ns_;  // of each executor
  std::vector<bool> throttled_;               // of each executor: it was said
  std::optional<Violations> violations_;      // where modules are checked
  channel::Channel channel_;
  os::SharedMemory bell_memory_;
  channel::Bell* bell_ = nullptr;
  Wiring wiring_;
  std::unique_ptr<Gate> gate_;
  std::vector<std::unique_ptr<Member>> members_;
  HostLink host_;
  struct PropertyRequest {
    std::uint32_t module;
    std::function<void(const Outcome&)> done;
  };
  std::map<std::uint64_t, PropertyRequest> property_requests_;  // that the host has not answered
  std::uint64_t property_requests_made_ = 0;
  std::map<std::pair<std::uint32_t, std::string>, std::uint32_t> matched_at_stop_;  // by module and port
  bool rows_begun_ = false;
  bool background_begun_ = false;
  bool halted_ = false;
  bool halt_asked_ = false;
  std::optional<Hang> hung_;       // for which the host was killed
  std::vector<Instant> restarts_;  // of the host, without a culprit
  std::uint32_t host_restarts_ = 0;
  std::optional<Instant> t0_;
  Instant asked_at_{};  // preparing: when it began; stopping: when the present part of it began
  bool end_asked_ = false;
};

}  // namespace takt::node
