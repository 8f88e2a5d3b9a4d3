// Changes the deployment of this device to a new descriptor.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/model/difference.hpp>
#include "deployment.hpp"

namespace takt::agent {

/// An update of the agent's deployment; a new deployment is an update from nothing. The agent checks the
/// update, and makes the changes when the client commands this. It then keeps or undoes the changes, as the
/// devices of the cell decide together (transactions.cpp). Modules that the update starts begin at T0.
class Agent::Update : public std::enable_shared_from_this<Agent::Update> {
 public:
  Update(Agent& agent, const wire::WholeCommand& command);

  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  [[nodiscard]] const Transaction& transaction() const { return after_->transaction; }
  /// The new deployment; its descriptor is empty if the update removes the device.
  [[nodiscard]] const Deployment& after() const { return *after_; }
  /// The deployment before the update; null if the update adds the device.
  [[nodiscard]] const Deployment* before() const {
    return before_ ? before_.get() : is_after_ ? nullptr : agent_.deployment_.get();
  }
  /// True if this is a new deployment.
  [[nodiscard]] bool is_deployment() const { return after_->update().empty(); }
  /// True if `after()` was started, or is being started.
  [[nodiscard]] bool is_after() const noexcept { return is_after_; }
  /// True if the update is being undone.
  [[nodiscard]] bool is_undoing() const noexcept { return stage_ == Stage::undoing; }
  /// True if the update is ending the old deployment or starting the new one, or is undoing these steps.
  [[nodiscard]] bool in_transit() const {
    const bool moves = stage_ == Stage::changing || stage_ == Stage::undoing;
    return moves && difference_.change != model::Change::none &&
           difference_.change != model::Change::in_place;
  }

  /// Returns what the operator should know about an update that is not over yet; may be empty.
  [[nodiscard]] std::string progress() const;

  /// Compares the running descriptor with the new one, without the components.
  Result<void> compare();
  /// Inspects the components of the new descriptor, and then answers the client. Call this once, after
  /// compare().
  void inspect();
  void step();
  /// Records that the client has sent a message, so that the update is not undone.
  void renew() { renewed_ = agent_.options_.now(); }

  // Commands of the updating client
  void change(const wire::WholeCommand& command);
  void run(const Command& command);
  void cancel(const Command& command);

  /// Undoes everything that the update has changed.
  void undo(const Problems& problems);
  /// Called when the present deployment is ending by itself. Undoes the update if the new deployment has
  /// failed before T0.
  void device_fails(const Problems& failures);
  /// Called when the present deployment has ended by itself. Undoes the update if the deployment is the new
  /// one, unless its failure stops the cell. A new deployment has no update to undo: if it fails after T0, it
  /// fails as a running device does.
  void device_ended(const Problems& failures, bool stops_cell);
  /// Ends the update, because the deployment that it changes has ended.
  void drop(const std::string& why, bool is_undeployed = false);
  /// Called when a deployment that the update has started or stopped has ended or could not be started.
  void taken_down(const Problems& problems);
  /// Ends the update when everything is undone.
  void undone();

 private:
  static constexpr const char* kCancelled = "the update was cancelled";
  enum class Stage {
    checking,  ///< the components are being inspected
    held,      ///< the update is checked and accepted; nothing is changed yet
    changing,
    changed,  ///< the changes are made, and can still be undone; they are on disk once is_complete()
    undoing,
  };

  // The steps of the update (updates.cpp)
  void inspected(const Result<Inspected>& result);
  void changed();
  /// Answers the client when the changes are on disk. From then on, the device can receive T0.
  void confirm();
  [[nodiscard]] bool is_complete() const { return stage_ == Stage::changed && !asker_; }
  [[nodiscard]] bool is_final() const { return transaction().state.stage == transaction::Stage::final; }
  /// Records why the update is undone. From now on, the other devices hear that it is.
  void note_undone(const Problems& problems);
  /// True if the changes are made and can still be undone because of a failure on this device.
  [[nodiscard]] bool is_before_t0() const;
  /// Returns why a module that the update has changed while it ran has failed, before T0.
  [[nodiscard]] std::optional<Problem> failed_change() const;
  void kept();
  // What the update changes on this device (differences.cpp)
  void add_rebuilt(const Inspected& found);
  void judge_in_place(const Inspected& found);
  [[nodiscard]] Result<void> may_change_in_place() const;
  // How the update is carried out and undone (changes.cpp)
  void apply_change(const model::ModuleChange& change, const std::string& value,
                    const std::function<void(const Outcome&)>& done);
  /// True if a swap of the module sets this property, in the new instance only.
  [[nodiscard]] bool is_set_by_swap(const model::ModuleChange& change) const;
  /// Returns the properties that a swap of the module sets, with their new values or those before the update.
  [[nodiscard]] std::map<std::string, std::string> set_by_swap(const std::string& module, bool before) const;
  void note_file(std::size_t index, const std::string& file);
  [[nodiscard]] bool stays_changed(const model::ModuleChange& change, const std::string& before);
  void connect();
  void begin();
  void change_next();
  void undo_last();
  void restart_undone();
  void bring_back();

  Agent& agent_;
  Stage stage_ = Stage::checking;
  const std::string id_;
  model::DeviceDifference difference_;
  std::unique_ptr<Deployment> after_;   ///< the new deployment, with the transaction of the update
  std::vector<model::Build> builds_;    ///< the builds of the components before the update
  std::unique_ptr<Deployment> before_;  ///< the deployment that the update has ended
  bool is_after_ = false;               ///< true: `after_` was started, or is being started
  bool carried_out_ = false;            ///< the device has begun to make its changes
  bool began_ = false;                  ///< the modules that the update has started have T0
  std::vector<std::string> replaced_;   ///< for changes in place: the old value or file of each change that
                                        ///< was made so far
  std::unique_ptr<Inspection> inspection_;
  std::optional<Command> asker_;             ///< a command to be answered after the present stage
  std::optional<Command> undoer_;            ///< a command to be answered when the update is undone
  Instant renewed_{};                        ///< when the updating client's last message arrived
  std::optional<Instant> ready_since_;       ///< since when all modules of the new deployment are in START
  std::optional<Instant> connecting_since_;  ///< since when all devices make their connections
  Problems reasons_;                         ///< why the update is undone
  Problems left_;                            ///< changes that could not be undone
};

}  // namespace takt::agent
