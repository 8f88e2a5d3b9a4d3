#include "contender.hpp"

#include <algorithm>

#include <takt/core/check.hpp>

namespace takt::schedule {

namespace {

/// The maximum number of rows for which sums of consecutive rows are computed exactly. For a longer table,
/// the load of the fullest row gives an upper bound of each sum.
constexpr std::size_t kExactRows = 4096;

Wide ceiling(Wide a, Wide b) { return a <= 0 ? 0 : (a + b - 1) / b; }

/// Returns `count` times `work`, but at most kForever.
Wide product(Wide count, Wide work) {
  return work != 0 && count >= kForever / work ? kForever : count * work;
}

}  // namespace

RowDemand::RowDemand(std::vector<Wide> work, Nanoseconds basic_period, Nanoseconds spin)
    : basic_(basic_period.count()), spin_(spin.count()) {
  TAKT_CHECK(!work.empty() && basic_ > 0);
  if (work.size() > kExactRows) {
    Wide sum = 0;
    for (const Wide one : work) sum += one;
    known_ = {{1, *std::max_element(work.begin(), work.end())}, {work.size(), sum}};
    return;
  }
  before_.reserve(2 * work.size() + 1);
  before_.push_back(0);
  for (int round = 0; round < 2; ++round) {
    for (const Wide one : work) before_.push_back(before_.back() + one);
  }
}

Wide RowDemand::most_of(std::size_t rows) const {
  if (rows == 0) return 0;
  if (before_.empty()) {
    const Wide all = known_.rbegin()->second;
    return std::min(all, known_.begin()->second * static_cast<Wide>(rows));
  }
  const auto [place, is_new] = known_.try_emplace(rows, 0);
  if (is_new) {
    for (std::size_t first = 0; first < before_.size() / 2; ++first)
      place->second = std::max(place->second, before_[first + rows] - before_[first]);
  }
  return place->second;
}

Wide RowDemand::in(Wide window) const {
  const Wide rows = ceiling(window, basic_);
  const auto in_circle = static_cast<Wide>(before_.empty() ? known_.rbegin()->first : before_.size() / 2);
  return product(rows / in_circle, most_of(static_cast<std::size_t>(in_circle))) +
         most_of(static_cast<std::size_t>(rows % in_circle)) + product(rows, spin_);
}

Wide Recurring::fresh(Wide window) const {
  return apart == 0 ? kForever : product(ceiling(window + jitter, apart), work);
}

// In the worst case, the window begins when the first release runs as late as possible, and all later
// releases run as soon as possible.
Wide Recurring::carried(Wide window) const {
  if (work >= apart) return window;
  const Wide reach = window + std::max(response, work) - work;
  if (reach < 0) return 0;
  const Wide whole = reach / apart;
  return product(whole, work) + std::min(work, reach - whole * apart);
}

bool Contender::may_run_on(int cpu) const { return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end(); }

Wide Contender::fresh(Wide window) const {
  if (kind == Kind::rows) return rows.in(window);
  Wide sum = 0;
  for (const Recurring& job : jobs) sum += job.fresh(window);
  return sum;
}

Wide Contender::carried(Wide window) const {
  if (kind == Kind::rows) return rows.in(window + rows_response + rows.spin());
  Wide sum = 0;
  for (const Recurring& job : jobs) sum += job.carried(window);
  return sum;
}

}  // namespace takt::schedule
