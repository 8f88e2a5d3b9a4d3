// The agent of one device: waits for deployments, brings one up at a time, and answers for it.
//
// Everything that it is told comes in by functions of one thread, and everything that it says goes out by its
// Publisher, so it knows neither DDS nor a clock of its own, and a test drives it. Nothing in it waits: what
// takes long is looked at in step().
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/dds/cell_state.hpp>
#include <takt/dds/commands.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/difference.hpp>
#include <takt/model/fault.hpp>
#include <takt/node/fault_record.hpp>
#include <takt/node/inspection.hpp>
#include <takt/node/kept_deployment.hpp>
#include <takt/node/supervisor.hpp>
#include "fault_rate_limiter.hpp"
#include "publisher.hpp"

namespace takt::node {

class Agent {
 public:
  struct Options {
    std::string device;
    std::string node;  ///< this node and no other
    int domain = 0;
    std::string cell{};  ///< the only one that its identity is for; empty: it has none, DDS Security is off
    bool require_real_time = false;
    bool real_time = true;  ///< what this machine allows, for who asks before there is a deployment
    /// It was started for one cell by somebody on this machine (takt run): files are looked up as they are
    /// written, nothing is kept on disk, and when it is to end it waits a little until its closing report was
    /// fetched.
    bool lent = false;
    std::optional<DeploymentFile> file;     ///< where the deployment is kept; none: nowhere
    std::string boot{};                     ///< os::boot_id()
    std::shared_ptr<FaultRecord> record{};  ///< none: one in memory
    std::function<Instant()> now;
    std::function<std::int64_t()> wall_ns;
    std::function<Instant(std::int64_t)> instant_of_wall;
  };
  /// What it sets to work.
  struct Workshop {
    std::function<Result<std::unique_ptr<Inspection>>(const InspectionRequest&)> inspect;
    std::function<std::unique_ptr<Supervised>(Supervisor::Options)> supervise;
  };

  Agent(Options options, Workshop workshop, Publisher& publisher);
  ~Agent();
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  /// For the fault record: this node is here, and is going. Between the two it did not end in order.
  void came_up();
  void goes_down();
  /// An event for the record and for observers. Time, cell and device are given here; `origin` as for the
  /// filter.
  void note(model::Fault fault, const std::string& origin = {});

  /// A command has come.
  void hear(const dds::WholeCommand& command);
  /// What the other nodes say, for the name that is taken and the devices that are lost.
  dds::CellState& others() noexcept { return others_; }
  /// Takes up the deployment that is kept on disk.
  void resume();
  /// Says that there is one, where it is not to be taken up.
  void leave_kept() const;
  /// Ends the deployment in order, and then itself. With `at_once` nobody is waited for who might want its
  /// report.
  void end(bool at_once);

  void step();
  [[nodiscard]] std::vector<const os::Fd*> wait_on();
  [[nodiscard]] bool ended() const;

 private:
  struct Deployment;
  struct Update;
  struct WholeDevice;

  // Commands (agent_commands.cpp)
  void report(const Command& command);
  void descriptor(const Command& command);
  void describe(const Command& command);
  void look_at_description();
  void described(const Result<Inspected>& result);
  void order(const Command& command, Verb verb);
  void tap(const Command& command);
  void trace(const Command& command);
  void swap(const Command& command);
  void look_at_swap();
  void property(const Command& command);
  /// False where there is nothing that could be told to do something; that is answered then.
  bool runs(const Command& command);
  /// None where there is no module of that name; that is answered then.
  std::optional<std::uint32_t> module_of(const Command& command);
  void answer(const Command& command, ReplyCode code, const std::string& text, std::string data = {},
              std::optional<lifecycle::State> state = {}, const std::string& value = {});
  [[nodiscard]] nlohmann::ordered_json lost_devices() const;

  // The fault record (agent_faults.cpp)
  void log_asked(const dds::WholeCommand& command);
  void note_answer(const Command& command, ReplyCode code, const std::string& text);
  void watch_devices();

  // Deployments (agent_deployment.cpp)
  void prepare(const dds::WholeCommand& command);
  void run(const dds::WholeCommand& command);
  void undeploy(const Command& command);
  void begin(std::unique_ptr<Deployment> deployment);
  void bring_up();
  [[nodiscard]] Result<void> check_security(const model::Cell& cell) const;
  void look_at_inspection();
  void look_at_supervised();
  void refuse(const Problems& problems);
  void go(std::int64_t t0_wall_ns);
  void finish();
  void keep_for_restart();
  void forget_kept();
  void clear();
  void stepped(const Step& step);
  [[nodiscard]] std::string occupied() const;

  // Updates (agent_update.cpp)
  void update(const dds::WholeCommand& command);
  void change(const dds::WholeCommand& command);
  void keep(const Command& command);
  void put_back(const Command& command);
  /// False where no such update is under way; that is answered then.
  bool updates(const Command& command);
  void complain(const Command& command, ReplyCode code, const Problems& problems,
                const std::string& value = {});
  Result<void> compare(Update& update) const;
  void look_at_update();
  void looked_at(const Result<Inspected>& result);
  void judge_in_place(const Inspected& found);
  [[nodiscard]] Result<void> may_change_in_place() const;
  void changed();
  void undo(const Problems& problems);
  void undone();
  /// Nothing of it is carried on: what it was about has ended.
  void drop_update(const std::string& why);
  // How they are carried out and put back (agent_change.cpp)
  void tell(const model::ModuleChange& change, const std::string& value,
            const std::function<void(const Outcome&)>& done);
  void change_next();
  void undo_last();
  void begin_again(const Deployment& description);
  /// The deployment that an update had to end has ended, or could not be brought up.
  void taken_down(const Problems& problems);
  void bring_back();
  void brought_up();

  void watch_names();
  void watch_cell();
  void watch_disk();
  [[nodiscard]] DeviceStatus status() const;
  void tell_status();
  void tell_measures();
  void log(const std::string& text) const;

  Options options_;
  Workshop workshop_;
  Publisher& publisher_;
  const Instant began_;
  dds::CellState others_;
  std::unique_ptr<Deployment> deployment_;
  std::shared_ptr<Update> update_;  // callbacks of its supervised device know whether it is still there
  std::string clash_;               // who else has this name; empty: nobody
  std::string last_id_;             // of the deployment that ended last, and what was said of it
  std::string last_data_;
  std::string last_refusal_;  // why a deployment could not be taken up again
  DeviceStatus told_;
  bool told_once_ = false;
  Instant measured_at_{};
  Instant disk_tried_at_{};
  std::uint64_t measures_told_ = 0;
  bool ending_ = false;
  bool at_once_ = false;
  std::optional<Instant> ended_at_;
  FaultRateLimiter filter_;
  std::map<std::string, bool> devices_seen_;  // of the cell, by name: alive when last looked at
};

}  // namespace takt::node
