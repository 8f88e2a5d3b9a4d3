// Limits the rate of fault events: a module may overrun ten thousand times a second, which would fill the
// record.
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

/// Emits the first event of a module and kind at once, and then at most one a second. The count of an emitted
/// event includes all events since the one emitted before, so no event goes uncounted. Single actions (a
/// deployment, a command, a restart) are always emitted at once. A merged event has the cause, cycle and time
/// of the newest event in it.
class FaultRateLimiter {
 public:
  static constexpr Nanoseconds kEvery = std::chrono::seconds{1};
  /// How many sources are tracked separately at the same time. Further sources of one kind share an entry.
  static constexpr std::size_t kMost = 256;

  explicit FaultRateLimiter(std::function<void(model::Fault)> emit) : emit_(std::move(emit)) {}

  /// Accepts an event. `origin` names its port, executor or client; each origin is limited separately.
  void put(model::Fault fault, Instant now, const std::string& origin = {});
  /// Emits merged events that are due.
  void step(Instant now);
  /// Emits all merged events.
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
