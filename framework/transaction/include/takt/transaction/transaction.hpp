// Decides whether a change of a cell takes place on all of its devices or on none.
//
// A change is a transaction: a deployment or an update. The operator distributes the new descriptor and then
// the start time, T0. Everything else is decided by the devices, each by itself, because the operator can be
// lost at any moment, and so can a device. Each device publishes its stage and hears the stages of the
// others, late or never. These functions know neither a network, a disk nor a clock, so a test can explore
// every order of events.
//
// The rules hold for any delay and for clocks that differ by any amount. They need three things from the
// caller. The change is on disk before a device is armed, and that it is final is on disk before the device
// acts on it or publishes it. A restarted device that was armed or running has undone the change; one that
// was final is still final. A device that has gone back keeps what it needs to go forward until settled() is
// true.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::transaction {

/// How far a device has come. A device only moves down this list, and it may leave out stages.
enum class Stage {
  prepared,  ///< has everything that it needs; waits for T0
  armed,     ///< has T0; waits to hear that all other devices have it too
  running,   ///< all devices were armed, so it has begun; waits to hear that all others have begun
  undone,    ///< has gone back to what was before
  final,     ///< every device has begun; the change will not be undone on any device
};

/// The state of one device in one transaction.
struct State {
  Stage stage = Stage::prepared;
  /// T0, in ns. All times of a transaction are on one clock, which must not be set during the transaction.
  std::int64_t t0_ns = 0;
  std::int64_t operator_heard_ns = 0;  ///< when the last message of the operator arrived
  std::string why{};                   ///< why the device has undone the change; otherwise empty
  bool operator==(const State&) const = default;
};

/// The state of another device, as this device has heard it last.
struct Heard {
  Stage stage = Stage::prepared;
  std::int64_t t0_ns = 0;  ///< valid from stage armed on
};

/// Each other device of the transaction, by name. Nothing: the device is lost, or has published nothing about
/// the transaction.
using Others = std::map<std::string, std::optional<Heard>>;

/// A prepared device undoes the change if the operator is silent for this time.
inline constexpr Nanoseconds kOperatorSilent = std::chrono::seconds{10};
/// The operator may set T0 at most this far in the future.
inline constexpr Nanoseconds kFurthestStart = std::chrono::seconds{60};
/// A device begins at the earliest this long before T0, and only if no other device is lost at that moment.
/// So it has enough time to begin exactly at T0, and most losses are noticed before anything runs.
inline constexpr Nanoseconds kBegins = std::chrono::milliseconds{300};
/// A device must have heard within this time after T0 that all others have begun.
inline constexpr Nanoseconds kHeardWithin = std::chrono::seconds{3};

/// Returns the state after this device has received T0 from the operator. Fails if the device cannot accept
/// T0: it has another T0, it has undone the change, or T0 is past or too far in the future. A repeated T0
/// changes nothing.
Result<State> receive_t0(const State& mine, std::int64_t t0_ns, std::int64_t now_ns);

/// Returns the state after a part of the change has failed on this device. A device in stage final stays
/// final: the failure is then one of a running device.
State fail(const State& mine, const std::string& why);

/// Returns the state that follows from what this device has heard and from the time. Call it often, and
/// whenever something is heard, until it returns `mine`.
State next(const State& mine, const Others& others, std::int64_t now_ns);

/// True if no device can go the other way any more, so this device need not keep what it would need for that.
bool settled(const State& mine, const Others& others);

}  // namespace takt::transaction
