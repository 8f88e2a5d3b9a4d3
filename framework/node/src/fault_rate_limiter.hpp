// What keeps a flood of faults from filling the record: a module may overrun ten thousand times a second.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <takt/core/time.hpp>
#include <takt/model/fault.hpp>

namespace takt::node {

/// Lets the first event of a module and kind through at once, and after that one a second with how often it
/// happened since: nothing is lost of the counts. What somebody does once (a deployment, a command, a
/// restart) always goes through. Of those that were put together, cause, cycle and time are the newest's.
class FaultRateLimiter {
 public:
  static constexpr Nanoseconds kEvery = std::chrono::seconds{1};
  /// Different ones that are looked after at once; all further ones of a kind are put together.
  static constexpr std::size_t kMost = 256;

  explicit FaultRateLimiter(std::function<void(model::Fault)> through) : through_(std::move(through)) {}

  /// `origin`: which port, which executor, whose command: each has events of its own.
  void put(model::Fault fault, Instant now, const std::string& origin = {});
  /// Lets through what was put together and is due.
  void step(Instant now);
  /// All of it.
  void flush();

 private:
  struct Heap {
    Instant let_through{};
    std::optional<model::Fault> waiting{};
  };
  using Key = std::pair<model::FaultKind, std::string>;

  std::function<void(model::Fault)> through_;
  std::map<Key, Heap> heaps_;
};

}  // namespace takt::node
