// The agent of one device: carries out commands, one deployment at a time.
//
// The node passes all input to the agent's functions, on one thread, and all output goes to the Publisher.
// The agent uses neither DDS nor a clock of its own, so a test can control it completely. The agent never
// waits: step() checks whether the results of long actions, such as inspections, have arrived.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/agent/clock_offset.hpp>
#include <takt/agent/fault_rate_limiter.hpp>
#include <takt/agent/inspection.hpp>
#include <takt/agent/memory.hpp>
#include <takt/agent/publisher.hpp>
#include <takt/model/alarm.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/difference.hpp>
#include <takt/model/fault.hpp>
#include <takt/supervision/supervisor.hpp>
#include <takt/transaction/transaction.hpp>
#include <takt/wire/assembly.hpp>
#include <takt/wire/cell_state.hpp>

namespace takt::agent {

using supervision::Measures;
using supervision::Outcome;
using supervision::Standing;
using supervision::Step;
using supervision::Supervised;
using supervision::Supervisor;
using supervision::Tapped;
using supervision::Verb;

class Agent {
 public:
  struct Options {
    std::string device;
    std::string node;  ///< unique id of this node
    int domain = 0;
    std::string cell{};  ///< the cell for which the device's identity was issued; empty if DDS Security is
                         ///< off
    bool require_real_time = false;
    bool real_time = true;  ///< true: the machine allows real time; published while there is no deployment
    /// True if `takt run` started this node for one cell. Such a node uses the paths of components as the
    /// descriptor states them, and saves nothing on disk. Before the node ends, it waits until `takt run` has
    /// received its final report, but at most kReportFetched.
    bool temporary = false;
    std::string host_name{};
    int process_id = 0;
    std::shared_ptr<DeploymentStore> store{};     ///< stores the deployment; null: nothing is stored
    std::string boot{};                           ///< identifies this boot of the machine; empty if not known
    std::shared_ptr<FaultMemory> record;          ///< never null
    std::function<void(const std::string&)> log;  ///< prints a line to the output of the node
    std::function<Instant()> now;
    std::function<std::int64_t()> wall_ns;
    std::function<Instant(std::int64_t)> instant_of_wall;
    /// Returns why this node no longer accepts the identity of a device; empty if it accepts it.
    std::function<std::string(const std::string& device)> rejection_of = [](const std::string&) {
      return std::string{};
    };
  };
  /// Functions that create what the agent uses. Tests and the simulation pass functions that create other
  /// things than a node does.
  struct Factories {
    /// Reads the cell from a descriptor. `file` is the descriptor's name, for messages.
    std::function<Result<model::Cell>(const std::string& text, const std::string& file)> parse;
    std::function<Result<std::unique_ptr<Inspection>>(const InspectionRequest&)> inspect;
    /// Shared, because the simulation keeps it longer than the agent does.
    std::function<std::shared_ptr<Supervised>(Supervisor::Options)> supervise;
  };

  Agent(Options options, Factories factories, Publisher& publisher);
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// note_start() and note_end() record the start and the end of this node in the fault record. A start
  /// without an end before it means that the previous node crashed.
  void note_start();
  void note_end();
  /// Records and publishes an event. Adds the event's time, cell and device. For `origin`, see
  /// FaultRateLimiter::put().
  void note(model::Fault fault, const std::string& origin = {});

  /// Carries out a command that has arrived.
  void receive(const wire::WholeCommand& command);
  /// Takes the status of a node, also of this one. A status of another node also answers earlier statuses of
  /// this node; from these answers, the agent measures the clock of the other node.
  void receive(const DeviceStatus& status, wire::WriterId writer, Instant arrived);
  /// The state of the other nodes, which the node updates. From this state, the agent detects lost devices,
  /// and other nodes with this node's device name.
  wire::CellState& others() noexcept { return others_; }
  /// Restores the deployment that is saved on disk. If another node with this device name has a deployment,
  /// the agent first waits until that node is gone.
  void resume();
  /// Logs that a deployment is saved but is not restored. Called if the node was started without --resume.
  void report_kept() const;
  /// Shuts down the deployment and then the agent. If `at_once` is true, the agent does not wait until `takt
  /// run` has received the final report.
  void end(bool at_once);

  void step();
  [[nodiscard]] bool ended() const;
  /// True if the agent has ended by itself, because another node with this device name executes in its place.
  [[nodiscard]] bool has_given_way() const noexcept { return has_given_way_; }

 private:
  struct Transaction;
  struct Deployment;
  class Update;
  struct WholeDevice;

  // Commands (commands.cpp)
  void report(const Command& command);
  void descriptor(const Command& command);
  void describe(const Command& command);
  void check_description();
  void described(const Result<Inspected>& result);
  void command_module(const Command& command, Verb verb);
  void tap(const Command& command);
  void force(const wire::WholeCommand& command);
  void end_force(const wire::WholeCommand& command);
  void trace(const Command& command);
  void swap(const Command& command);
  void check_swap();
  void property(const Command& command);
  /// Returns true if a deployment runs. Otherwise rejects the command and returns false.
  bool runs(const Command& command);
  /// Returns the index of the module that the command names. If the device has no such module, rejects the
  /// command and returns nothing.
  std::optional<std::uint32_t> module_of(const Command& command);
  void answer(const Command& command, ReplyCode code, const std::string& text, std::string data = {},
              std::optional<lifecycle::State> state = {}, const std::string& value = {});
  void answer_outcome(const Command& command, const Outcome& outcome);
  [[nodiscard]] nlohmann::ordered_json lost_devices() const;

  // The fault record (faults.cpp)
  void send_log(const wire::WholeCommand& command);
  void note_answer(const Command& command, ReplyCode code, const std::string& text);
  void check_devices();
  void send_alarms(const Command& command);
  void acknowledge(const wire::WholeCommand& command);
  /// Updates which alarms are active, and adds their numbers to the status.
  void update_alarms(DeviceStatus& status);

  // Deployments (deployments.cpp)
  void undeploy(const Command& command);
  /// Returns the deployment that this device has or prepares, or null.
  [[nodiscard]] const Deployment* present() const;
  /// Reads the descriptor of a deployment, and plans the device's schedule, so that no later step can fail
  /// because there is no schedule. Returns whether the device is part of the cell.
  Result<bool> read(Deployment& deployment) const;
  void begin(std::unique_ptr<Deployment> deployment);
  void bring_up();
  [[nodiscard]] Result<void> check_security(const model::Cell& cell) const;
  void check_inspection();
  void step_supervised();
  void abandon(const Problems& problems);
  void go();
  void take_back(const std::string& why);
  void check_undeployed();
  [[nodiscard]] bool was_undeployed(const std::string& id) const;
  void remember_undeployed(const std::string& id);
  [[nodiscard]] std::string undeployed_but_held() const;
  void stop();
  void finish();
  void clear();
  void stepped(const Step& step);

  // What the devices decide about deployments and updates (transactions.cpp)
  void step_gone();
  void go_forward();
  /// Decides about a transaction, by what was heard from the other devices. Returns true if the stage has
  /// changed. `operator_heard` is when the operator's last message arrived; nothing if the device does not
  /// wait for the operator.
  bool decide(Transaction& transaction, std::optional<Instant> operator_heard);
  Result<void> receive_t0(Transaction& transaction, std::int64_t t0_ns);
  [[nodiscard]] transaction::Others heard(const Transaction& transaction) const;
  [[nodiscard]] std::int64_t time_of(const Transaction& transaction) const;
  /// Returns the transaction in which this device takes part or took part last, or null.
  [[nodiscard]] const Transaction* newest_transaction() const;
  void set_gone(std::unique_ptr<Deployment> deployment);
  void drop_gone();

  // The saved deployment (restart.cpp)
  void keep_for_restart();
  void restore();
  [[nodiscard]] bool check_start(const KeptDeployment& kept);
  [[nodiscard]] bool is_of_this_boot(const KeptDeployment& kept) const;
  [[nodiscard]] std::unique_ptr<Deployment> restored(const KeptDeployment& kept) const;
  void check_disk();
  void check_saved();
  /// True if everything that was to be saved is on disk, or could not be written.
  [[nodiscard]] bool is_saved() const noexcept { return !saving_; }
  /// Answers a command when everything is saved.
  void answer_when_saved(const Command& command, const std::string& text, const std::string& data);

  // Updates (updates.cpp)
  void prepare(const wire::WholeCommand& command);
  [[nodiscard]] std::optional<Problem> obstacle(const Command& command) const;
  /// Returns the update that the command names. If that update is not in progress, rejects the command and
  /// returns null.
  Update* update_of(const Command& command);
  void put_back(const Command& command);
  [[nodiscard]] std::string undecided_on() const;
  [[nodiscard]] Problem why_undone() const;
  void reply_problems(const Command& command, ReplyCode code, const Problems& problems,
                      const std::string& value = {});
  void begin_again(const Deployment& description, const Transaction& transaction);

  // The clocks of the other devices (clocks.cpp)
  [[nodiscard]] std::optional<ClockBounds> clock_of(const std::string& device) const;
  [[nodiscard]] std::optional<ClockBounds> ahead(const std::string& device) const;
  [[nodiscard]] std::optional<ClockBounds> first_ahead() const;
  [[nodiscard]] nlohmann::ordered_json clock_report() const;
  void add_clock(DeviceStatus& status) const;
  void check_clocks();

  // Other nodes with this device name (twins.cpp)
  void check_names();
  void check_interruption();
  void check_resume();
  [[nodiscard]] std::chrono::seconds uninterrupted() const;
  [[nodiscard]] bool gives_way_to(const DeviceStatus& other) const;
  void give_way();

  void check_cell();
  [[nodiscard]] DeviceStatus status() const;
  void publish_status();
  void publish_measures();
  void log(const std::string& text) const;

  Options options_;
  Factories factories_;
  Publisher& publisher_;
  const Instant began_;
  Instant stepped_at_;  // when step() was called last
  wire::CellState others_;
  std::unique_ptr<Deployment> deployment_;
  // The newest deployment or update, if this device has undone it, or if it has removed this device from the
  // cell. The device goes forward again if it hears that an undone one is final.
  std::unique_ptr<Deployment> gone_;
  std::shared_ptr<Update> update_;  // shared, so that callbacks can check whether it still exists
  bool saving_ = false;             // the result of the last save is not known yet
  bool unsaved_ = false;            // the deployment could not be written to disk; the agent will try again
  std::string twin_;        // id and activity of another node with this device name; empty if there is none
  std::string name_clash_;  // describes that node
  std::optional<Instant> both_execute_since_;   // since when that node and this node execute
  std::optional<Instant> uninterrupted_since_;  // see DeviceStatus::uninterrupted_s
  bool resuming_ = false;                       // the agent calls restore() after resume_at_
  Instant resume_at_{};
  std::optional<Instant> waits_since_;  // since when another node keeps this node from resuming
  bool has_given_way_ = false;
  std::string last_id_;       // id of the deployment that ended last
  std::string last_data_;     // the final report of the deployment that ended last
  std::string last_refusal_;  // the reason why the saved deployment could not be restored, or why a
                              // deployment was undone
  struct WaitingAnswer {
    Command command;
    std::string text;
    std::string data;
  };
  std::vector<WaitingAnswer> answers_;   // see answer_when_saved()
  std::vector<std::string> undeployed_;  // ids of the deployments that were undeployed or undone last
  DeviceStatus published_;
  bool published_once_ = false;
  Instant stood_still_until_{};
  Nanoseconds stood_still_for_{0};  // how long step() was not called before that instant
  Instant measured_at_{};
  Instant disk_tried_at_{};
  std::uint64_t measures_published_ = 0;
  bool ending_ = false;
  bool at_once_ = false;
  std::optional<Instant> ended_at_;
  model::Alarms alarms_;
  FaultRateLimiter filter_;
  std::int64_t wall_ahead_ns_ = 0;  ///< wall clock minus monotonic clock, in ns
  struct OtherClock {
    std::string node;
    ClockOffset offset;
    bool differs = false;  // true: the fault record says that the clocks differ by more than kClocksDiffer
  };
  std::map<std::string, OtherClock> clocks_;  // by the name of the device
  std::map<std::string, bool> devices_seen_;  // for each other device of the cell: whether it was alive at
                                              // the last check
};

}  // namespace takt::agent
