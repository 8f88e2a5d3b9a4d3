#include <takt/schedule/table.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace takt::schedule {
namespace {

// A 128-bit integer: it can hold the least common multiple of any two periods (2^126) and any sum of entries.
__extension__ using UnsignedWide = unsigned __int128;

constexpr UnsignedWide kMaxPeriod = std::numeric_limits<std::int64_t>::max();

std::uint64_t period_of(const Task& task) { return static_cast<std::uint64_t>(task.period.count()); }

UnsignedWide least_common_multiple(std::uint64_t a, std::uint64_t b) {
  return UnsignedWide{a / std::gcd(a, b)} * b;
}

/// The size of a table before it is built. If the macro period is too long, `macro` is empty and `rows` and
/// `entries` are not set.
struct Extent {
  std::uint64_t basic = 0;
  std::optional<std::uint64_t> macro;
  std::uint64_t rows = 0;
  UnsignedWide entries = 0;
};

Extent measure(std::span<const Task> tasks) {
  Extent extent;
  for (const Task& task : tasks) {
    extent.basic = std::gcd(extent.basic, period_of(task));
    extent.basic = std::gcd(extent.basic, static_cast<std::uint64_t>(task.offset.count()));
  }

  std::uint64_t macro = 1;
  for (const Task& task : tasks) {
    const UnsignedWide next = least_common_multiple(macro, period_of(task));
    if (next > kMaxPeriod) return extent;
    macro = static_cast<std::uint64_t>(next);
  }
  extent.macro = macro;
  extent.rows = macro / extent.basic;
  for (const Task& task : tasks) extent.entries += macro / period_of(task);
  return extent;
}

std::string number(UnsignedWide value) {
  std::string digits;
  do {
    digits.insert(digits.begin(), static_cast<char>('0' + static_cast<int>(value % 10)));
    value /= 10;
  } while (value != 0);
  return digits;
}

std::string duration(UnsignedWide ns) {
  if (ns > kMaxPeriod) return "more than 10^18 ns";
  return to_text(Nanoseconds{static_cast<std::int64_t>(ns)});
}

std::string name_of(std::span<const Task> tasks, std::size_t index) {
  const Task& task = tasks[index];
  return task.name.empty() ? "task " + std::to_string(index) : "'" + std::string{task.name} + "'";
}

bool fits(const Extent& extent) {
  return extent.macro && extent.entries <= kMaxEntries && extent.rows <= kMaxRows;
}

/// A period near the period of a task with which the table is small enough.
struct NearbyPeriod {
  std::size_t task = 0;
  std::uint64_t period = 0;
};

/// Rounds the period of tasks[index] to few digits. Returns none if the table is too large with each of them.
std::optional<NearbyPeriod> rounded_period(std::span<const Task> tasks, std::size_t index) {
  std::vector<Task> changed{tasks.begin(), tasks.end()};
  const std::uint64_t period = period_of(tasks[index]);
  for (const std::uint64_t most : {100U, 1000U, 10U}) {  // two digits, three digits, one digit
    std::uint64_t unit = 1;
    while (period / unit >= most) unit *= 10;
    const std::uint64_t rounded = (period + unit / 2) / unit * unit;
    if (rounded == period || rounded > kMaxPeriod) continue;
    changed[index].period = Nanoseconds{static_cast<std::int64_t>(rounded)};
    if (tasks[index].offset < changed[index].period && fits(measure(changed)))
      return NearbyPeriod{index, rounded};
  }
  return std::nullopt;
}

Problem too_large(std::span<const Task> tasks, const Extent& extent) {
  std::string what;
  if (!extent.macro) {
    what = "the macro period is too long";
  } else if (extent.entries > kMaxEntries) {
    what = "the table would have " + number(extent.entries) + " entries, at most " +
           std::to_string(kMaxEntries) + " are allowed";
  } else {
    what = "the table would have " + std::to_string(extent.rows) + " rows, at most " +
           std::to_string(kMaxRows) + " are allowed";
  }
  what += " (basic period " + duration(extent.basic) + ", macro period " +
          (extent.macro ? duration(*extent.macro) : "more than 10^18 ns") + ")";

  std::uint64_t by_periods = 0;
  for (const Task& task : tasks) by_periods = std::gcd(by_periods, period_of(task));
  if (extent.macro && by_periods != extent.basic && *extent.macro / by_periods <= kMaxRows &&
      extent.entries <= kMaxEntries) {
    const auto finest = std::find_if(tasks.begin(), tasks.end(), [by_periods](const Task& task) {
      return static_cast<std::uint64_t>(task.offset.count()) % by_periods != 0;
    });
    return {{},
            what + ": without offsets, the basic period would be " + duration(by_periods) + ", but " +
                name_of(tasks, static_cast<std::size_t>(finest - tasks.begin())) + " has an offset of " +
                to_text(finest->offset),
            "choose offsets that are multiples of " + duration(by_periods)};
  }

  const auto [shorter, longer] = longest_pair(tasks);
  if (shorter == longer) {
    return {{},
            what + ": " + std::to_string(tasks.size()) + " modules have the same period, " +
                to_text(tasks[shorter].period),
            "distribute them over several executors"};
  }
  const std::uint64_t low = period_of(tasks[shorter]);
  const std::uint64_t high = period_of(tasks[longer]);
  what += ": " + name_of(tasks, shorter) + " with " + to_text(tasks[shorter].period) + " and " +
          name_of(tasks, longer) + " with " + to_text(tasks[longer].period) + " coincide only once in " +
          duration(least_common_multiple(low, high));
  if (high % low == 0)
    return {{}, what, "bring the two periods closer together, or give each module its own executor"};
  auto nearby = rounded_period(tasks, longer);
  if (!nearby) nearby = rounded_period(tasks, shorter);
  if (!nearby)
    return {
        {}, what, "choose periods that are multiples of each other, or give each module its own executor"};
  return {{},
          what,
          "give " + name_of(tasks, nearby->task) + " a period of " + duration(nearby->period) +
              ", or give each module its own executor"};
}

}  // namespace

PeriodPair longest_pair(std::span<const Task> tasks) {
  std::vector<std::uint32_t> order(tasks.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](auto a, auto b) { return tasks[a].period > tasks[b].period; });
  order.erase(std::unique(order.begin(), order.end(),
                          [&](auto a, auto b) { return tasks[a].period == tasks[b].period; }),
              order.end());

  // Start with the longest periods, so that each inner loop ends early. The inner loop ends when the product
  // of the two periods, divided by the common divisor of all periods, is smaller than the largest multiple so
  // far.
  std::uint64_t common = 0;
  for (const auto index : order) common = std::gcd(common, period_of(tasks[index]));
  PeriodPair best{};
  UnsignedWide largest = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::uint64_t high = period_of(tasks[order[i]]);
    for (std::size_t j = i + 1; j < order.size(); ++j) {
      const std::uint64_t low = period_of(tasks[order[j]]);
      if (UnsignedWide{high} * (low / common) < largest) break;
      const UnsignedWide multiple = least_common_multiple(high, low);
      if (multiple < largest) continue;
      if (multiple == largest && tasks[order[j]].period >= tasks[best.shorter].period) continue;
      largest = multiple;
      best = {.shorter = order[j], .longer = order[i]};
    }
  }
  return best;
}

Result<Table> Table::build(std::span<const Task> tasks) {
  Problems problems;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const Task& task = tasks[i];
    if (task.period.count() <= 0) {
      problems.push_back({{},
                          "the period of " + name_of(tasks, i) + " is " + to_text(task.period),
                          "give it a period of at least 1 ns"});
    } else if (task.offset.count() < 0 || task.offset >= task.period) {
      problems.push_back(
          {{},
           "the offset of " + name_of(tasks, i) + " is " + to_text(task.offset),
           "give it an offset of at least 0 and less than its period, " + to_text(task.period)});
    }
  }
  if (!problems.empty()) return problems;

  Table table;
  if (tasks.empty()) return table;
  const Extent extent = measure(tasks);
  if (!fits(extent)) return too_large(tasks, extent);

  table.basic_ = Nanoseconds{static_cast<std::int64_t>(extent.basic)};
  table.macro_ = Nanoseconds{static_cast<std::int64_t>(*extent.macro)};
  const std::size_t rows = extent.rows;
  const auto stride = [&](const Task& task) {
    return static_cast<std::size_t>(period_of(task) / extent.basic);
  };
  const auto first_row = [&](const Task& task) {
    return static_cast<std::size_t>(static_cast<std::uint64_t>(task.offset.count()) / extent.basic);
  };

  // At first, `offsets` holds the number of entries of each row, then the index of each row's first entry.
  std::vector<Index>& offsets = table.offsets_;
  offsets.assign(rows + 1, 0);
  for (const Task& task : tasks) {
    const std::size_t step = stride(task);
    for (std::size_t row = first_row(task); row < rows; row += step) ++offsets[row];
  }
  std::exclusive_scan(offsets.begin(), offsets.end(), offsets.begin(), Index{0});

  // Visit the tasks in the order of priority, so that each row is filled in that order. In this loop, the
  // offset of a row advances to the end of the row, which is the beginning of the next row.
  std::vector<Index> order(tasks.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return tasks[a].priority < tasks[b].priority; });
  table.entries_.resize(static_cast<std::size_t>(extent.entries));
  for (const Index index : order) {
    const std::size_t step = stride(tasks[index]);
    for (std::size_t row = first_row(tasks[index]); row < rows; row += step) {
      table.entries_[offsets[row]++] = index;
    }
  }
  std::copy_backward(offsets.begin(), offsets.end() - 1, offsets.end());
  offsets.front() = 0;
  return table;
}

}  // namespace takt::schedule
