// The operator of a simulated cell: does what takt deploy, takt deploy --update and takt undeploy do. The
// commands, the replies and the statuses of the devices pass through the simulated network.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <takt/simulation/simulation.hpp>
#include "device.hpp"

namespace takt::simulation {

class Operator {
 public:
  explicit Operator(const World& world);
  Operator(const Operator&) = delete;
  Operator& operator=(const Operator&) = delete;

  /// Begins an action, or does so after the action in progress.
  void begin(Action action) { waiting_.push_back(action); }
  /// The first deployment of the simulation, whose T0 is given.
  void begin_at(Instant t0);
  /// The operator dies, and can begin other actions after this time.
  void go_down(Nanoseconds lasts);
  /// The operator does not wait for the end of the action in progress and of the waiting ones.
  void end(const std::string& why);
  /// The operator does nothing for this time.
  void pause(Nanoseconds lasts);

  void receive(const wire::WholeReply& reply);
  void hear(const DeviceStatus& status);

  /// Returns what the operator has reported at the end of each action.
  [[nodiscard]] const std::vector<Report>& reports() const noexcept { return reports_; }

 private:
  enum class Stage { nothing, preparing, changing, running, deciding, undoing, agreeing };
  enum class Replies { open, good, bad };
  struct Seen {
    DeviceStatus status{};
    Instant at{};
  };
  struct Open {
    std::uint32_t device;
    std::string node;
    Instant sent;
    std::optional<ReplyCode> code{};
    std::string text{};
  };

  void step();
  void next_action();
  void decide();
  void agree();
  /// Undoes the deployment or the update, or ends a deployment.
  void undo(std::string why);
  void send(CommandKind kind, Nanoseconds limit);
  /// Returns whether every open command has a good reply. A command fails if its node is lost for some time,
  /// if the limit has passed, or if two nodes have the name.
  Replies replies();
  void finish(Outcome outcome);
  [[nodiscard]] bool is_alive(std::uint32_t device) const { return !alive(device).empty(); }
  [[nodiscard]] bool is_alive(const Seen& seen) const;
  /// Returns the nodes of a device that are alive.
  [[nodiscard]] std::vector<const Seen*> alive(std::uint32_t device) const;
  /// Notes why the action fails, unless another reason is noted.
  void note(std::uint32_t device, const std::string& why);
  [[nodiscard]] std::size_t in_stage(TransactionStage stage) const;
  [[nodiscard]] std::size_t devices() const { return world_.cell().devices.size(); }
  [[nodiscard]] const SimulatedCell& version() const {
    return world_.versions[action_ == Action::update ? 1 : 0];
  }

  const World& world_;
  std::deque<Action> waiting_;
  Action action_ = Action::deploy;
  Stage stage_ = Stage::nothing;
  std::uint64_t actions_ = 0;
  std::uint64_t commands_ = 0;
  std::string deployment_;   // id
  std::string transaction_;  // id of the deployment or update in progress
  std::int64_t t0_ns_ = 0;   // of the deployment in progress; for an update, that of the changes
  std::optional<Instant> given_t0_;
  std::int64_t deployed_t0_ns_ = 0;
  std::string why_;
  bool run_sent_ = false;
  bool unreached_ = false;
  Instant since_{};      // since when the devices are to agree
  Nanoseconds limit_{};  // of the open commands
  Instant kept_alive_{};
  Instant away_until_{};
  std::map<std::string, Open> open_;               // by the id of the command
  std::vector<std::map<std::string, Seen>> seen_;  // by device and node
  std::vector<Report> reports_;
};

}  // namespace takt::simulation
