// The agent of one device: carries out commands, one deployment at a time.
//
// All input arrives through its functions, called on one thread, and all output goes to its Publisher. It
// uses neither DDS nor a clock of its own, so tests can drive it. It never waits: step() looks for the
// results of everything that takes long.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/agent/fault_rate_limiter.hpp>
#include <takt/agent/inspection.hpp>
#include <takt/agent/memory.hpp>
#include <takt/agent/publisher.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/difference.hpp>
#include <takt/model/fault.hpp>
#include <takt/supervision/supervisor.hpp>
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
    std::string cell{};  ///< the cell that the device's identity is for; empty if DDS Security is off
    bool require_real_time = false;
    bool real_time = true;  ///< whether the machine allows real time; reported without a deployment
    /// Whether takt run started this node for one cell. Such a node uses the paths of files as written and
    /// saves nothing on disk. Before it ends, it waits briefly for its final report to be fetched.
    bool temporary = false;
    std::string host_name{};
    int process_id = 0;
    std::shared_ptr<DeploymentStore> store{};     ///< where the deployment is saved; null to save nothing
    std::string boot{};                           ///< identifies this boot of the machine; empty if not known
    std::shared_ptr<FaultMemory> record;          ///< never null
    std::function<void(const std::string&)> log;  ///< prints a line for the person at the terminal
    std::function<Instant()> now;
    std::function<std::int64_t()> wall_ns;
    std::function<Instant(std::int64_t)> instant_of_wall;
  };
  /// Creates the inspections and supervisions that the agent uses; tests pass fakes.
  struct Factories {
    std::function<Result<std::unique_ptr<Inspection>>(const InspectionRequest&)> inspect;
    std::function<std::unique_ptr<Supervised>(Supervisor::Options)> supervise;
  };

  Agent(Options options, Factories factories, Publisher& publisher);
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// Record the start and the end of this node. Two starts in a row mean that the first node crashed.
  void note_start();
  void note_end();
  /// Records and publishes an event. Adds its time, cell and device. See FaultRateLimiter::put() for
  /// `origin`.
  void note(model::Fault fault, const std::string& origin = {});

  /// Carries out a command that has arrived.
  void receive(const wire::WholeCommand& command);
  /// The state of the other nodes. It shows lost devices, and other nodes with this node's name.
  wire::CellState& others() noexcept { return others_; }
  /// Restores the deployment that is saved on disk.
  void resume();
  /// Logs that there is a saved deployment, for a node started without --resume.
  void report_kept() const;
  /// Shuts the deployment and then the agent down. With `at_once` it does not wait for its final report to be
  /// fetched.
  void end(bool at_once);

  void step();
  [[nodiscard]] bool ended() const;

 private:
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
  void trace(const Command& command);
  void swap(const Command& command);
  void check_swap();
  void property(const Command& command);
  /// Whether a deployment runs. If not, rejects the command.
  bool runs(const Command& command);
  /// The index of the module that the command names. Rejects the command if there is no such module.
  std::optional<std::uint32_t> module_of(const Command& command);
  void answer(const Command& command, ReplyCode code, const std::string& text, std::string data = {},
              std::optional<lifecycle::State> state = {}, const std::string& value = {});
  [[nodiscard]] nlohmann::ordered_json lost_devices() const;

  // The fault record (faults.cpp)
  void send_log(const wire::WholeCommand& command);
  void note_answer(const Command& command, ReplyCode code, const std::string& text);
  void watch_devices();

  // Deployments (deployments.cpp)
  void prepare(const wire::WholeCommand& command);
  void run(const wire::WholeCommand& command);
  void undeploy(const Command& command);
  void begin(std::unique_ptr<Deployment> deployment);
  void bring_up();
  [[nodiscard]] Result<void> check_security(const model::Cell& cell) const;
  void check_inspection();
  void step_supervised();
  void abandon(const Problems& problems);
  void go(std::int64_t t0_wall_ns);
  void finish();
  void keep_for_restart();
  void forget_kept();
  void clear();
  void stepped(const Step& step);
  [[nodiscard]] std::string occupied() const;

  // Updates (updates.cpp)
  void update(const wire::WholeCommand& command);
  /// The update that the command names. If it is not in progress, rejects the command and returns null.
  Update* update_of(const Command& command);
  void reply_problems(const Command& command, ReplyCode code, const Problems& problems,
                      const std::string& value = {});
  void begin_again(const Deployment& description);

  void watch_names();
  void watch_cell();
  void watch_disk();
  [[nodiscard]] DeviceStatus status() const;
  void publish_status();
  void publish_measures();
  void log(const std::string& text) const;

  Options options_;
  Factories factories_;
  Publisher& publisher_;
  const Instant began_;
  wire::CellState others_;
  std::unique_ptr<Deployment> deployment_;
  std::shared_ptr<Update> update_;  // shared, so that callbacks can check whether it still exists
  std::string name_clash_;          // describes the other node with this name; empty if there is none
  std::string last_id_;             // id of the deployment that ended last
  std::string last_data_;           // its final report
  std::string last_refusal_;        // why a deployment could not be restored
  DeviceStatus published_;
  bool published_once_ = false;
  Instant measured_at_{};
  Instant disk_tried_at_{};
  std::uint64_t measures_published_ = 0;
  bool ending_ = false;
  bool at_once_ = false;
  std::optional<Instant> ended_at_;
  FaultRateLimiter filter_;
  std::map<std::string, bool> devices_seen_;  // for each other device of the cell: whether it was alive at
                                              // the last check
};

}  // namespace takt::agent
