// takt bench wake: measures how punctually an executor wakes up, with each wake-up strategy.
#include <array>
#include <cmath>

#include <fmt/format.h>

#include <takt/os/waker.hpp>

#include "bare_loop.hpp"
#include "benchmarks.hpp"

namespace takt::bench {

namespace {

using model::Wakeup;
using namespace std::chrono_literals;

constexpr double kWakeSeconds = 5;
constexpr int kWakeTurns = 5;
constexpr int kWays = 4;

// Unlike an executor's jitter, the delay of a wake-up counts from the instant that the thread waited for,
// even if later instants have passed too. Otherwise, no delay could be longer than a period.
Loop wake_ups(Nanoseconds period, Nanoseconds length, const std::function<Instant(Instant)>& wait) {
  const Grid grid = Grid::from_now(period, length);
  std::vector<std::int64_t> delays(grid.instants());
  std::size_t count = 0;
  Loop loop = loop_on_grid(grid, [&](Instant release) {
    const Instant now = wait(release);
    delays[count++] = (release - now).count();
    return now;
  });
  delays.resize(count);
  loop.jitter = std::move(delays);
  return loop;
}

Loop wait_by(Wakeup strategy, Nanoseconds period, Nanoseconds length) {
  const std::atomic<std::uint32_t> stop{0};
  os::Waker waker{strategy, os::margin_cap(period, model::Executor{}.spin_share), stop};
  return wake_ups(period, length, [&waker](Instant release) { return waker.wait_until(release); });
}

Result<Section> at_period(Nanoseconds period, const Scheduling& scheduling, Nanoseconds length,
                          Course& course, Problems& refused) {
  struct Way {
    const char* name;
    std::function<Loop()> loop;
    Loop seen{};
  };
  const auto by = [=](Wakeup strategy) {
    return [=] { return wait_by(strategy, period, length / kWakeTurns); };
  };
  std::array<Way, kWays> ways{{{"bare loop", [=] { return wake_ups(period, length / kWakeTurns, sleep_to); }},
                               {"sleep", by(Wakeup::sleep)},
                               {"hybrid", by(Wakeup::hybrid)},
                               {"spin", by(Wakeup::spin)}}};
  for (int turn = 0; turn < kWakeTurns; ++turn) {
    for (Way& way : ways) {
      course.next(fmt::format("wake-up by {} at {}", way.name, takt::to_text(period)));
      const auto loop = run_at(scheduling, way.loop);
      if (!loop) return loop.problems();
      way.seen.add(*loop);
    }
  }
  Section section{.title = fmt::format("delay of the wake-up, every {}, on CPU {} with priority {}",
                                       takt::to_text(period), scheduling.cpu, scheduling.priority),
                  .columns = time_columns()};
  for (const char* column : {"cycles", "missed", "processor %"}) section.columns.emplace_back(column);
  section.notes = {
      "missed: releases that passed during a delay of more than a period, besides the one that was waited "
      "for"};
  for (const Way& way : ways) {
    const Distribution d = distribution_of(way.seen.jitter);
    Row row{way.name, in_columns(d)};
    row.values.push_back(static_cast<double>(d.count));
    row.values.push_back(static_cast<double>(way.seen.missed));
    row.values.push_back(100 * static_cast<double>(way.seen.cpu_time.count()) /
                         static_cast<double>(length.count()));
    section.rows.push_back(row);
    add_once(refused, way.seen.refused);
  }
  return section;
}

}  // namespace

Result<std::vector<Section>> wake(const Settings& settings, Problems& refused) {
  std::vector<Nanoseconds> periods{100us, 1ms};
  if (settings.period) periods = {*settings.period};
  Course course{settings, static_cast<int>(periods.size()) * kWakeTurns * kWays};
  std::vector<Section> sections;
  for (const Nanoseconds period : periods) {
    auto section =
        at_period(period, {.cpu = cpu_of(settings)}, settings.length(kWakeSeconds), course, refused);
    if (!section) return section.problems();
    sections.push_back(std::move(*section));
  }
  return sections;
}

}  // namespace takt::bench
