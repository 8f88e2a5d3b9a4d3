// An update of the agent's deployment, on this device.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/model/difference.hpp>
#include "deployment.hpp"

namespace takt::agent {

/// An update of the agent's deployment. It is checked, waits for the client, is carried out, waits for the
/// client again, and is then kept or undone. So either all devices of a cell carry it out or none.
class Agent::Update : public std::enable_shared_from_this<Agent::Update> {
 public:
  Update(Agent& agent, const wire::WholeCommand& command);

  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  /// Whether this is the id of the new deployment.
  [[nodiscard]] bool leads_to(const std::string& deployment) const { return after_->id == deployment; }
  /// Whether the update is ending a deployment or bringing one up at this moment.
  [[nodiscard]] bool in_transit() const {
    const bool moves = stage_ == Stage::changing || stage_ == Stage::undoing;
    return moves && difference_.change != model::Change::none &&
           difference_.change != model::Change::in_place;
  }
  /// Whether the new deployment was brought up, or is being brought up.
  [[nodiscard]] bool has_replaced() const noexcept { return is_after_; }

  /// Compares the descriptors, without the components.
  Result<void> compare();
  /// Inspects the components of the new descriptor, then answers the client. Call it once, after compare().
  void inspect();
  void step();
  /// Records that the updating client is alive.
  void renew() { renewed_ = agent_.options_.now(); }

  // Commands of the updating client
  void change(const wire::WholeCommand& command);
  void keep(const Command& command);
  void cancel(const Command& command);

  /// Undoes everything that the update has changed.
  void undo(const Problems& problems);
  /// Ends the update, because the deployment that it changes has ended.
  void drop(const std::string& why);
  /// Called when the deployment that the update ends is down, or when the new one could not be brought up.
  void taken_down(const Problems& problems);
  void brought_up();

 private:
  enum class Stage {
    checking,  ///< the components are being inspected
    held,      ///< checked and accepted; nothing is changed yet
    changing,
    changed,  ///< carried out; it can still be undone
    undoing,
  };

  // Checks (updates.cpp)
  void inspected(const Result<Inspected>& result);
  void judge_in_place(const Inspected& found);
  [[nodiscard]] Result<void> may_change_in_place() const;
  void changed();
  void undone();
  // How it is carried out and undone (changes.cpp)
  void apply_change(const model::ModuleChange& change, const std::string& value,
                    const std::function<void(const Outcome&)>& done);
  void change_next();
  void undo_last();
  void bring_back();

  Agent& agent_;
  Stage stage_ = Stage::checking;
  const std::string id_;
  model::DeviceDifference difference_;
  std::unique_ptr<Deployment> after_;   ///< the new deployment; not brought up if the device is removed
  std::unique_ptr<Deployment> before_;  ///< the deployment that the update has ended
  bool is_after_ = false;               ///< `after_` was, or is being, brought up
  std::vector<std::string> replaced_;   ///< for a change in place: the old value or file of each module
                                        ///< changed so far
  std::unique_ptr<Inspection> inspection_;
  std::optional<Command> asker_;   ///< to be answered when the present stage is over
  std::optional<Command> undoer_;  ///< to be answered when the update is undone
  Instant renewed_{};                ///< when the updating client's last message arrived
  Problems reasons_;               ///< why the update is undone
  Problems left_;                  ///< what could not be undone
};

}  // namespace takt::agent
