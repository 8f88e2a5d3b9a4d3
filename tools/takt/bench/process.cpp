// takt bench process: measures the time from the release of a process module to the start of its body.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/os/machine.hpp>
#include <takt/os/waker.hpp>

#include "bare_loop.hpp"
#include "benchmarks.hpp"
#include "measured_cell.hpp"
#include "peer.hpp"
#include "programs.hpp"
#include "scratch_folder.hpp"

namespace takt::bench {

namespace {

using namespace std::chrono_literals;

constexpr double kProcessSeconds = 5;
constexpr Nanoseconds kProcessPeriod = 1ms;
constexpr int kProcessTurns = 2;

struct SeenWakes {
  std::vector<std::int64_t> jitter;
  std::uint64_t missed = 0;
};

// Measures the reference: a thread that wakes another process at each release, as the paper's scheduler does,
// without Takt.
Result<SeenWakes> wake_a_peer(WakeBy by, const Scheduling& scheduling, int other_cpu, Nanoseconds period,
                              Nanoseconds length, Problems& refused) {
  const Grid now = Grid::from_now(period, length);
  auto peer = Peer::start(by, {.cpu = other_cpu, .priority = scheduling.priority - 1}, now.instants() + 1);
  if (!peer) return peer.problems();
  SeenWakes seen;
  const auto loop = run_at(scheduling, [&] {
    const std::atomic<std::uint32_t> stop{0};
    os::Waker waker{model::Wakeup::hybrid, os::margin_cap(period, model::Executor{}.spin_share), stop};
    return loop_on_grid(
        Grid::from_now(period, length), [&waker](Instant release) { return waker.wait_until(release); },
        [&](Instant release) {
          if (!peer->wake(release)) ++seen.missed;
        });
  });
  if (!loop) return loop.problems();
  add_once(refused, loop->refused);
  if (peer->refused())
    add_once(refused, {fail("the second process has no real-time scheduling", "run takt bench as root")});
  seen.missed += loop->missed;
  seen.jitter = peer->jitter();
  return seen;
}

}  // namespace

Result<std::vector<Section>> process(const Settings& settings, Problems& refused) {
  const Scheduling scheduling{.cpu = cpu_of(settings)};
  const std::vector<int> cpus = os::read_cpus().ordinary;
  // The first CPU that the executor does not use. A node also runs process modules on CPUs without an
  // executor.
  const auto other =
      std::find_if(cpus.begin(), cpus.end(), [&scheduling](int cpu) { return cpu != scheduling.cpu; });
  const int other_cpu = other == cpus.end() ? scheduling.cpu : *other;
  const Nanoseconds period = settings.period.value_or(kProcessPeriod);
  const Nanoseconds length = settings.length(kProcessSeconds) / kProcessTurns;
  auto interruption = Interruption::create();
  if (!interruption) return interruption.problems();
  const auto folder = ScratchFolder::create();
  if (!folder) return folder.problems();
  Table1Case one;
  one.exe = 1;
  one.measured = model::ModuleType::process;

  const std::vector<std::string> names{"process module", "futex", "signal"};
  std::vector<SeenWakes> seen(names.size());
  const auto add = [&seen](std::size_t way, const SeenWakes& more) {
    seen[way].jitter.insert(seen[way].jitter.end(), more.jitter.begin(), more.jitter.end());
    seen[way].missed += more.missed;
  };
  Course course{settings, kProcessTurns * static_cast<int>(names.size())};
  for (int turn = 0; turn < kProcessTurns; ++turn) {
    course.next(names[0]);
    const auto measured = run_measured(one,
                                       {.period = period,
                                        .cpu = scheduling.cpu,
                                        .priority = scheduling.priority,
                                        .length = length,
                                        .domain = settings.domain},
                                       *folder, *interruption);
    if (!measured) return measured.problems();
    add(0, {values_of(measured->jitter), measured->missed});
    if (!measured->real_time)
      add_once(refused, {fail("the node's threads have no real-time scheduling", "run takt bench as root")});
    for (const WakeBy by : {WakeBy::futex, WakeBy::signal}) {
      if (interruption->ended()) return asked_to_end();
      const std::size_t way = by == WakeBy::futex ? 1 : 2;
      course.next(names[way]);
      const auto woken = wake_a_peer(by, scheduling, other_cpu, period, length, refused);
      if (!woken) return woken.problems();
      add(way, *woken);
    }
  }
  Section section{
      .title = fmt::format(
          "from the release to the start of the body in another process, every {}, from CPU {} to CPU {}",
          takt::to_text(period), scheduling.cpu, other_cpu),
      .columns = time_columns()};
  section.columns.emplace_back("cycles");
  section.columns.emplace_back("missed");
  std::vector<double> medians;
  for (std::size_t way = 0; way < seen.size(); ++way) {
    const Distribution d = distribution_of(seen[way].jitter);
    Row row{names[way], in_columns(d)};
    row.values.push_back(static_cast<double>(d.count));
    row.values.push_back(static_cast<double>(seen[way].missed));
    section.rows.push_back(row);
    medians.push_back(d.p50);
  }
  section.notes = {
      "All releases come from a thread that wakes up like an executor. For the process module, this is the "
      "executor of a host.",
      fmt::format("p50 of the process module: {:.2f} us (target: at most 1 us; the paper: 5.5 to 6 us)",
                  medians[0] / 1e3)};
  return std::vector<Section>{std::move(section)};
}

}  // namespace takt::bench
