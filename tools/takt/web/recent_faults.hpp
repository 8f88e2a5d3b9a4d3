// Keeps the newest events of the fault records of all devices, for the pages.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/model/fault.hpp>

namespace takt::tool::web {

/// The events of the last hour, oldest first, but at most kMost. A cell with few events keeps kNewest events
/// of any age. Each event has a number, so that a page can request the events before those that it has. Takes
/// about 400 bytes per event.
class RecentFaults {
 public:
  static constexpr std::size_t kMost = 20'000;      ///< limit of the kept events
  static constexpr std::size_t kNewest = 500;       ///< number of events that newest() returns
  static constexpr std::size_t kMostAtOnce = 2000;  ///< limit of the events that before() returns
  static constexpr std::chrono::hours kKept{1};

  /// Adds an event that has just arrived, and returns it as JSON.
  std::string add(const model::Fault& fault);
  /// Adds the events of a fault record by their time, except those that are known, and numbers all events
  /// anew. `complete` is false if the record has lost events that are older than these.
  void add_record(const std::vector<model::Fault>& events, bool complete);

  /// Returns these members of a JSON object:
  /// - `events`: the events, oldest first,
  /// - `older`: the argument of before() that returns the next older events; 0 if there are none,
  /// - `complete_since_ms`: no event after this time is missing.
  [[nodiscard]] std::string newest() const;
  /// Like newest(), with the events before the event with this number. Returns none if the number is unknown.
  [[nodiscard]] std::string before(std::uint64_t number) const;

 private:
  struct Event {
    std::int64_t time_ns = 0;
    std::string text;
  };
  void forget();
  [[nodiscard]] std::string members(std::size_t begin, std::size_t end) const;

  std::deque<Event> events_;
  std::uint64_t first_ = 1;             // the number of the first event
  std::int64_t complete_since_ns_ = 0;  // no event after this time is missing
};

}  // namespace takt::tool::web
