#include "table1.hpp"

#include <algorithm>
#include <optional>

#include <fmt/format.h>

#include <takt/os/clock.hpp>
#include <takt/os/machine.hpp>

#include "bare_loop.hpp"
#include "measured_cell.hpp"
#include "programs.hpp"
#include "scratch_folder.hpp"
#include "table1_cases.hpp"

namespace takt::bench {

namespace {

constexpr int kPriority = 80;
constexpr double kTable1Seconds = 10;

class Table1Run {
 public:
  Table1Run(const Settings& settings, Table1Result& result, const ScratchFolder& folder,
            Interruption& interruption)
      : settings_(settings),
        result_(result),
        folder_(folder),
        interruption_(interruption),
        course_(settings, 3 * static_cast<int>(kTable1.size())) {}

  Result<CaseResult> run(const Table1Case& one) {
    CaseResult measured;
    measured.one = one;
    measured.loop_real_time = true;
    const std::string name = fmt::format("case {} of {}: ", one.number, kTable1.size());
    course_.next(name + "bare loop, first half");
    if (auto half = run_half(measured); !half) return half.problems();
    course_.next(name + "Takt");
    if (auto done = run_takt(measured); !done) return done.problems();
    course_.next(name + "bare loop, second half");
    if (auto half = run_half(measured); !half) return half.problems();
    measured.loop = distribution_of(measured.bare);
    return measured;
  }

 private:
  // Runs the bare loop for half of its time, in parts of 1 s, so that Ctrl-C takes effect within a second.
  Result<void> run_half(CaseResult& measured) {
    constexpr Nanoseconds kPart = std::chrono::seconds{1};
    for (Nanoseconds left = settings_.length(kTable1Seconds) / 2; left >= result_.period; left -= kPart) {
      if (interruption_.ended()) return asked_to_end();
      const auto loop = run_bare_loop({.cpu = result_.cpu, .priority = result_.priority}, result_.period,
                                      std::min(left, kPart));
      if (!loop) return loop.problems();
      measured.bare.insert(measured.bare.end(), loop->jitter.begin(), loop->jitter.end());
      measured.loop_missed += loop->missed;
      measured.loop_real_time &= loop->refused.empty();
    }
    return {};
  }

  Result<void> run_takt(CaseResult& measured) {
    auto ran = run_measured(measured.one,
                            {.period = result_.period,
                             .cpu = result_.cpu,
                             .priority = result_.priority,
                             .length = settings_.length(kTable1Seconds),
                             .domain = settings_.domain},
                            folder_, interruption_);
    if (!ran) return ran.problems();
    measured.jitter = std::move(ran->jitter);
    measured.takt = distribution_of(values_of(measured.jitter));
    measured.cycles = ran->cycles;
    measured.missed = ran->missed;
    measured.real_time = ran->real_time;
    measured.stolen = ran->stolen;
    return {};
  }

  const Settings& settings_;
  Table1Result& result_;
  const ScratchFolder& folder_;
  Interruption& interruption_;
  Course course_;
};

}  // namespace

Result<Table1Result> run_table1(const Settings& settings, const Table1Progress& progress) {
  Table1Result result{.machine = os::describe_platform(),
                      .wall_ns = os::wall_ns(),
                      .period = settings.period.value_or(kTable1Period),
                      .seconds = settings.seconds.value_or(kTable1Seconds),
                      .cpu = cpu_of(settings),
                      .priority = kPriority,
                      .cpus = static_cast<int>(os::read_cpus().permitted.size()),
                      .load = "",
                      .cases = {}};
  auto interruption = Interruption::create();
  if (!interruption) return interruption.problems();
  const auto folder = ScratchFolder::create();
  if (!folder) return folder.problems();
  std::optional<Load> load;
  if (settings.load) {
    auto started = Load::start();
    if (!started) return started.problems();
    load.emplace(std::move(*started));
    result.load = Load::words();
  }
  progress(result);
  Table1Run run{settings, result, *folder, *interruption};
  for (const Table1Case& one : kTable1) {
    auto measured = run.run(one);
    if (!measured) {
      Problems problems = measured.problems();
      for (Problem& problem : problems) problem.where = "case " + std::to_string(one.number);
      return problems;
    }
    result.cases.push_back(std::move(*measured));
    progress(result);
  }
  return result;
}

}  // namespace takt::bench
