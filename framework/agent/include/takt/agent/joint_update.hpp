// Decides whether all devices of a cell keep an update or undo it.
#pragma once

#include <map>
#include <optional>
#include <string>

#include <takt/core/time.hpp>

namespace takt::agent {

/// The vote of another device on an update, as this device has last heard it.
enum class Vote {
  nothing,  ///< nothing yet, or its node is lost
  absent,   ///< its node is alive, but publishes nothing about this update
  open,     ///< it may still fail
  changed,  ///< it has made its changes, and leaves the decision to the others
  kept,     ///< it has decided that the cell is updated
  undone,   ///< it has failed or given up
};

/// All devices of a cell must keep an update, or all must undo it, but the operator can be lost at any
/// moment. So a device that has made its changes decides by what it hears from the others. It keeps the
/// update when all others have made their changes too, and undoes it when another device has failed. A device
/// that may still fail decides alone. The class knows neither the network nor a clock.
class JointUpdate {
 public:
  enum class Decision { wait, keep, undo };
  /// The longest time that a device may be alive without publishing anything about the update. After this
  /// time, its node must have been restarted.
  static constexpr Nanoseconds kAbsent = std::chrono::seconds{10};

  /// `added` is true if the update adds this device to the cell. Such a device does not know the devices that
  /// the update removes, so it never decides first.
  explicit JointUpdate(bool added) : added_(added) {}

  /// Returns what this device must do now. `others` contains each other device of the old and the new cell.
  /// After this device has made its changes, call step() repeatedly until it returns keep or undo.
  Decision step(Instant now, const std::map<std::string, Vote>& others);
  /// Why the update is undone; empty if it is not.
  [[nodiscard]] const std::string& why() const noexcept { return why_; }

 private:
  const bool added_;
  std::optional<Instant> absent_since_;
  std::string why_;
};

}  // namespace takt::agent
