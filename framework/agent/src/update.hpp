// The state of an update of the agent's deployment.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/model/difference.hpp>
#include "deployment.hpp"

namespace takt::agent {

/// An update is checked, held, carried out, held, and then kept or undone. So either all devices of a cell
/// carry it out or none.
struct Agent::Update {
  enum class Stage {
    checking,  ///< the components are being inspected
    held,      ///< checked and accepted; nothing is changed yet
    changing,
    changed,  ///< carried out; it can still be undone
    undoing,
  };
  Stage stage = Stage::checking;
  std::string id;
  model::DeviceDifference difference;
  std::unique_ptr<Deployment> after;   ///< the new deployment; not brought up if the device is removed
  std::unique_ptr<Deployment> before;  ///< the deployment that the update has ended
  bool is_after = false;               ///< `after` was, or is being, brought up
  std::vector<std::string> replaced;   ///< in place: the old value or file of each change made so far
  std::unique_ptr<Inspection> inspection;

  std::optional<Command> asker;   ///< to be answered when the present stage is over
  std::optional<Command> undoer;  ///< to be answered when the update is undone
  Instant heard{};                ///< when the updating client's last message arrived
  Problems reasons;               ///< why the update is undone
  Problems left;                  ///< what could not be undone

  /// Whether the update is ending a deployment or bringing one up at this moment.
  [[nodiscard]] bool in_transit() const {
    const bool moves = stage == Stage::changing || stage == Stage::undoing;
    return moves && difference.change != model::Change::none && difference.change != model::Change::in_place;
  }
};

}  // namespace takt::agent
