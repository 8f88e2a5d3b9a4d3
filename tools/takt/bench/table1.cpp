#include "table1.hpp"

#include <optional>

#include <nlohmann/json.hpp>

#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/real_time.hpp>

#include "bare_loop.hpp"
#include "programs.hpp"
#include "scratch_folder.hpp"

namespace takt::bench {

namespace {

using json = nlohmann::ordered_json;

constexpr int kPriority = 80;
constexpr double kSeconds = 10;

// As much as the module may be called in that time, and a little for the end, which is not to the period.
std::size_t releases_in(Nanoseconds length, Nanoseconds period) {
  return static_cast<std::size_t>(length / period) * 11 / 10 + 1000;
}

std::vector<std::int64_t> values(const std::vector<Served>& served) {
  std::vector<std::int64_t> values;
  values.reserve(served.size());
  for (const Served& one : served) values.push_back(one.value);
  return values;
}

class Table1Run {
 public:
  Table1Run(const Settings& settings, Table1Result& result, const ScratchFolder& folder, Patience& patience)
      : settings_(settings), result_(result), folder_(folder), patience_(patience) {}

  Result<CaseResult> run(const Table1Case& one) {
    CaseResult measured;
    measured.one = one;
    measured.loop_real_time = true;
    if (auto half = run_half(measured); !half) return half.problems();
    if (auto done = run_takt(measured); !done) return done.problems();
    if (auto half = run_half(measured); !half) return half.problems();
    measured.loop = distribution_of(measured.bare);
    return measured;
  }

 private:
  // Of the bare loop.
  Result<void> run_half(CaseResult& measured) {
    if (patience_.ended()) return fail("asked to end before everything was measured");
    const auto loop = run_bare_loop({.cpu = result_.cpu, .priority = result_.priority}, result_.period,
                                    settings_.length(kSeconds) / 2);
    if (!loop) return loop.problems();
    measured.bare.insert(measured.bare.end(), loop->jitter.begin(), loop->jitter.end());
    measured.loop_missed += loop->missed;
    measured.loop_real_time &= loop->refused.empty();
    return {};
  }

  Result<void> run_takt(CaseResult& measured) {
    const std::string name = "case" + std::to_string(measured.one.number);
    const std::string record = folder_.file(name + ".jitter");
    const auto file = folder_.write(
        name + ".xml",
        descriptor_of(measured.one, {.period = result_.period,
                                     .cpu = result_.cpu,
                                     .priority = result_.priority,
                                     .file = record,
                                     .releases = releases_in(settings_.length(kSeconds), result_.period)}));
    if (!file) return file.problems();
    std::vector<std::string> arguments{"run",     *file,   "--json",
                                       "--quiet", "--for", std::to_string(result_.seconds)};
    if (settings_.domain) {
      arguments.emplace_back("--domain");
      arguments.push_back(std::to_string(*settings_.domain));
    }
    const Nanoseconds stolen = os::stolen_time();
    const auto output = run_beside("takt", arguments, patience_);
    if (!output) return output.problems();
    measured.stolen = os::stolen_time() - stolen;

    const json report = json::parse(*output);
    const json& device = report["devices"][0];
    measured.real_time = device["real_time"].get<bool>();
    measured.cycles = device["executors"][0]["cycles"].get<std::uint64_t>();
    measured.missed = device["executors"][0]["missed"].get<std::uint64_t>();
    measured.jitter = Recording::read(record);
    measured.takt = distribution_of(values(measured.jitter));
    return os::remove_file(record);
  }

  const Settings& settings_;
  Table1Result& result_;
  const ScratchFolder& folder_;
  Patience& patience_;
};

}  // namespace

Result<Table1Result> run_table1(const Settings& settings, const Table1Progress& progress) {
  Table1Result result{.machine = os::describe_machine(),
                      .wall_ns = os::wall_ns(),
                      .period = settings.period.value_or(kTable1Period),
                      .seconds = settings.seconds.value_or(kSeconds),
                      .cpu = cpu_of(settings),
                      .priority = kPriority,
                      .processors = static_cast<int>(os::allowed_cpus().size()),
                      .load = "",
                      .cases = {}};
  auto patience = Patience::create();
  if (!patience) return patience.problems();
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
  Table1Run run{settings, result, *folder, *patience};
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
