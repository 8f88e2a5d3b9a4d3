// Keeps the values of a port for hours in bounded memory, and loses no peak.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include <takt/core/time.hpp>

namespace takt::tool::web {

/// The values of a port, newest last. The older values are, the fewer are kept: in each interval, only the
/// minimum and the maximum of each field, in their order in time.
class ValueHistory {
 public:
  struct Row {
    std::int64_t time_ns = 0;
    std::vector<double> values;  ///< one per field; NaN if the value is missing or not finite
  };

  /// Values up to this age are kept in these intervals. The page repeats this table in value_rows.js.
  struct Stage {
    Nanoseconds interval;
    Nanoseconds age;
  };
  static constexpr std::array<Stage, 3> kStages{{
      {std::chrono::milliseconds{20}, std::chrono::minutes{5}},
      {std::chrono::milliseconds{200}, std::chrono::minutes{30}},
      {std::chrono::seconds{2}, std::chrono::hours{4}},
  }};
  /// A clock that is set back by more than this makes the history begin anew.
  static constexpr std::chrono::seconds kOutOfOrder{1};

  void add(std::int64_t time_ns, const std::vector<double>& values);
  /// Ends the present interval, so that after() returns its values, too.
  void complete();
  /// Drops the values from before `time_ns`.
  void forget(std::int64_t time_ns);

  [[nodiscard]] std::int64_t newest() const { return newest_; }
  /// Returns the rows that are newer than `time_ns`, oldest first: all of them, or at least `enough`. In the
  /// latter case, the last one is at the end of an interval of the last stage, so none is lost or repeated if
  /// the history has thinned its rows before the next call. Valid until the history changes.
  [[nodiscard]] std::vector<const Row*> after(std::int64_t time_ns, std::size_t enough) const;

 private:
  /// One interval: two rows are enough for the minimum and the maximum of each of its fields.
  class Interval {
   public:
    void add(std::int64_t time_ns, const std::vector<double>& values);
    void move_to(std::deque<Row>& rows);
    [[nodiscard]] bool empty() const { return count_ == 0; }
    [[nodiscard]] std::int64_t begin() const { return first_.time_ns; }

   private:
    Row first_;  // of each field, the extreme that came first
    Row second_;
    std::size_t count_ = 0;
  };

  void thin();

  Interval open_;
  std::array<std::deque<Row>, kStages.size()> rows_;  // one per stage, the newest stage first
  std::int64_t newest_ = 0;
};

}  // namespace takt::tool::web
