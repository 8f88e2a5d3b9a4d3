// Decides whether all devices of a cell start together.
#pragma once

#include <map>
#include <string>

#include <takt/core/time.hpp>

namespace takt::agent {

/// The condition of another device of the deployment, as this device has last heard it. The values are in the
/// order in which a device goes through these conditions.
enum class Heard {
  nothing,   ///< nothing yet, or its node is lost
  ended,     ///< its node is alive, but does not have the deployment any more
  prepared,  ///< it has the deployment, but not with the same T0
  armed,     ///< it has the same T0, and waits to hear that all others have it too
  started,   ///< it runs, and waits to hear that all others run
  running,   ///< it has heard that all others run
};

/// A cell must run on all of its devices or on none, but the operator can be lost after it has sent T0 to
/// some of the devices, and a device can be lost at any moment. So each device decides by what it hears from
/// the others. A device begins only when it has heard that every other device is armed for the same T0, and
/// it fails if it has not heard soon after T0 that every other device runs. A device that fails publishes
/// this, and then the others fail too. The class knows neither the network nor a clock.
class JointStart {
 public:
  enum class Stage {
    armed,    ///< waits for the others
    begun,    ///< all others are armed; the first row runs at T0
    started,  ///< T0 has passed; waits to hear that all others run
    running,  ///< all others run
    failed,   ///< the deployment must be undone
  };
  /// A device begins at the earliest this long before T0, and only if no other device is lost at that moment.
  /// So its host has enough time to begin at T0, and most losses are noticed before anything runs.
  static constexpr Nanoseconds kBegins = std::chrono::milliseconds{300};
  /// A device must have heard within this time after T0 that all others run.
  static constexpr Nanoseconds kHeardWithin = std::chrono::seconds{3};

  explicit JointStart(Instant t0) : t0_(t0) {}

  /// `others` contains each other device of the cell. Call it often, and whenever something is heard.
  void step(Instant now, const std::map<std::string, Heard>& others);

  [[nodiscard]] Stage stage() const noexcept { return stage_; }
  /// Why the start has failed; empty if it has not.
  [[nodiscard]] const std::string& why() const noexcept { return why_; }

 private:
  void fail(const std::string& why);

  const Instant t0_;
  Stage stage_ = Stage::armed;
  std::string why_;
};

}  // namespace takt::agent
