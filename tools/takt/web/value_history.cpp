#include "web/value_history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace takt::tool::web {

namespace {

std::int64_t interval_of(std::int64_t time_ns, Nanoseconds interval) { return time_ns / interval.count(); }

double finite(double value) {
  return std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void ValueHistory::Interval::add(std::int64_t time_ns, const std::vector<double>& values) {
  second_.time_ns = time_ns;
  if (count_++ == 0) {
    first_.time_ns = time_ns;
    first_.values.resize(values.size());
    std::transform(values.begin(), values.end(), first_.values.begin(), finite);
    second_.values = first_.values;
    return;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double value = finite(values[i]);
    double& first = first_.values[i];
    double& second = second_.values[i];
    if (std::isnan(first)) {
      first = second = value;
    } else if (value < std::min(first, second)) {
      first = std::max(first, second);
      second = value;
    } else if (value > std::max(first, second)) {
      first = std::min(first, second);
      second = value;
    }
  }
}

void ValueHistory::Interval::move_to(std::deque<Row>& rows) {
  if (count_ > 0) rows.push_back(std::move(first_));
  if (count_ > 1) rows.push_back(std::move(second_));
  *this = {};
}

void ValueHistory::add(std::int64_t time_ns, const std::vector<double>& values) {
  if (time_ns <= newest_) {
    if (Nanoseconds{newest_ - time_ns} > kOutOfOrder) {
      *this = {};
    } else {
      time_ns = newest_ + 1;
    }
  }
  newest_ = time_ns;
  const Nanoseconds interval = kStages.front().interval;
  if (!open_.empty() && interval_of(open_.begin(), interval) != interval_of(time_ns, interval)) complete();
  open_.add(time_ns, values);
}

void ValueHistory::complete() {
  if (open_.empty()) return;
  open_.move_to(rows_.front());
  thin();
}

void ValueHistory::forget(std::int64_t time_ns) {
  for (std::deque<Row>& rows : rows_)
    while (!rows.empty() && rows.front().time_ns < time_ns) rows.pop_front();
}

// Moves the rows that are too old for their stage to the next stage, in whole intervals of that stage.
void ValueHistory::thin() {
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    const bool last = i + 1 == kStages.size();
    const Nanoseconds interval = kStages[last ? i : i + 1].interval;
    const std::int64_t end = interval_of(newest_ - kStages[i].age.count(), interval);
    Interval moved;
    for (std::deque<Row>& rows = rows_[i]; !rows.empty(); rows.pop_front()) {
      const Row& row = rows.front();
      if (interval_of(row.time_ns, interval) >= end) break;
      if (last) continue;
      if (!moved.empty() && interval_of(moved.begin(), interval) != interval_of(row.time_ns, interval))
        moved.move_to(rows_[i + 1]);
      moved.add(row.time_ns, row.values);
    }
    if (!last) moved.move_to(rows_[i + 1]);
  }
}

std::vector<const ValueHistory::Row*> ValueHistory::after(std::int64_t time_ns, std::size_t enough) const {
  std::vector<const Row*> found;
  for (auto rows = rows_.rbegin(); rows != rows_.rend(); ++rows) {
    for (auto row = std::upper_bound(rows->begin(), rows->end(), time_ns,
                                     [](std::int64_t time, const Row&one) { return time < one.time_ns; });
         row != rows->end(); ++row) {
      if (found.size() >= enough && interval_of(found.back()->time_ns, kStages.back().interval) !=
                                        interval_of(row->time_ns, kStages.back().interval)) {
        return found;
      }
      found.push_back(&*row);
    }
  }
  return found;
}

}  // namespace takt::tool::web
