// Limits the rate of fault events, because a module may overrun ten thousand times a second, which would fill
// the fault record.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <takt/core/time.hpp>
#include <takt/model/fault.hpp>

namespace takt::agent {

/// Emits the first event of a module and kind at once, and then at most one event per second. Events between
/// two emitted events are merged into the later one, whose count includes them. A merged event has the cause,
/// cycle and time of its newest event. Events of single actions (a deployment, a command, a restart) are
/// always emitted at once.
class FaultRateLimiter {
 public:
  static constexpr Nanoseconds kEvery = std::chrono::seconds{1};
  /// The number of combinations of kind, module, error and origin that are limited separately at the same
  /// time. Further combinations share one entry for each kind.
  static constexpr std::size_t kMost = 256;

  explicit FaultRateLimiter(std::function<void(model::Fault)> emit) : emit_(std::move(emit)) {}

  /// Accepts an event, and emits or merges it. `origin` names the port, executor or client that caused the
  /// event; each origin is limited separately.
  void put(model::Fault fault, Instant now, const std::string& origin = {});
  /// Emits merged events that are due.
  void step(Instant now);
  /// Emits all merged events, even those that are not due.
  void flush();

 private:
  struct Bucket {
    Instant passed_at{};
    std::optional<model::Fault> merged{};
  };
  using Key = std::pair<model::FaultKind, std::string>;

  std::function<void(model::Fault)> emit_;
  std::map<Key, Bucket> buckets_;
};

}  // namespace takt::agent
