// What an agent knows of an update of its deployment that is under way.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/model/difference.hpp>
#include "agent_deployment.hpp"

namespace takt::node {

/// Looked at, held, carried out, held, and then kept or put back: so that either all devices of a cell do it
/// or none.
struct Agent::Update {
  enum class Stage {
    looking,  ///< at the components
    held,     ///< it is right, and nothing is changed yet
    changing,
    changed,  ///< carried out, and can still be put back
    undoing,
  };
  Stage stage = Stage::looking;
  std::string id;
  model::DeviceDifference difference;
  std::unique_ptr<Deployment>
      after;  ///< what is to follow; of a removed device nothing is brought up from it
  std::unique_ptr<Deployment> before;  ///< what was taken down
  bool is_after = false;               ///< what the device has, or was to have, was brought up from `after`
  std::vector<std::string> replaced;   ///< in place: the value or file before each change that was made
  std::unique_ptr<Inspection> inspection;

  std::optional<Command> asker;   ///< to be answered when the present stage is over
  std::optional<Command> undoer;  ///< to be answered when it is put back
  Instant heard{};                ///< from who carries it out
  Problems reasons;               ///< why it is put back
  Problems left;                  ///< what could not be

  /// It ends a deployment, or brings one up, at this moment.
  [[nodiscard]] bool in_transit() const {
    const bool moves = stage == Stage::changing || stage == Stage::undoing;
    return moves && difference.change != model::Change::none && difference.change != model::Change::in_place;
  }
};

}  // namespace takt::node
