// takt bench: measures how fast and how punctual Takt is on this machine, and compares it with a reference.
#include <algorithm>
#include <memory>
#include <optional>

#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/output_file.hpp>
#include <takt/os/real_time.hpp>

#include <takt/client/network.hpp>

#include "bench/bare_dds.hpp"
#include "bench/benchmarks.hpp"
#include "bench/peer.hpp"
#include "bench/programs.hpp"
#include "bench/settings.hpp"
#include "bench/table1.hpp"
#include "bench/table1_page.hpp"
#include "bench/table1_report.hpp"
#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/ranges.hpp"
#include "terminal/progress.hpp"
#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

struct BenchOptions {
  bench::Settings settings;
  std::optional<double> period_us;
  bool json = false;
  std::string html;
};

// If standard error is a terminal, adds to the settings a callback that shows the progress.
bench::Settings with_progress(bench::Settings settings, Progress& progress) {
  if (progress.is_seen()) {
    settings.progress = [&progress](double share, const std::string& what) {
      progress.show(share_text(share, what, {.unicode = is_utf8()}));
    };
  }
  return settings;
}

// Locks this process's memory. Otherwise the first page fault would look like a late wake-up.
Problems lock_memory() {
  const auto locked = os::lock_memory();
  return locked ? Problems{} : locked.problems();
}

int table1(const BenchOptions& options) {
  static_cast<void>(lock_memory());  // if this fails, real-time scheduling fails too, and that is reported
  std::optional<os::OutputFile> page;
  if (!options.html.empty()) {
    auto opened = os::OutputFile::open(options.html);  // before the measurements, which take minutes
    if (!opened) {
      complain(opened.problems());
      return 1;
    }
    page = std::move(*opened);
  }
  const auto print_text = [&options](const std::string& text) { return options.json || print(text); };
  Progress progress;
  const auto result =
      bench::run_table1(with_progress(options.settings, progress), [&](const bench::Table1Result& so_far) {
        progress.clear();
        print_text(so_far.cases.empty() ? bench::table1_head(so_far)
                                        : bench::table1_rows(so_far.cases.back(), so_far));
      });
  if (!result) {
    complain(result.problems());
    return 1;
  }
  if (!print_text(bench::table1_foot())) return 1;
  if (options.json && !print(model::json_text(bench::table1_json(*result)) + "\n")) return 1;
  if (!page) return 0;
  page->write(bench::table1_page(*result));
  if (const auto written = page->close(); !written) {
    complain(written.problems());
    return 1;
  }
  return 0;
}

using Benchmark = Result<std::vector<bench::Section>> (*)(const bench::Settings&, Problems&);

int measure(const char* name, Benchmark benchmark, const BenchOptions& options) {
  bench::Report report{.benchmark = name,
                       .machine = os::describe_platform(),
                       .wall_ns = os::wall_ns(),
                       .refused = lock_memory()};
  std::optional<bench::Load> load;
  if (options.settings.load) {
    auto started = bench::Load::start();
    if (!started) {
      complain(started.problems());
      return 1;
    }
    load.emplace(std::move(*started));
    report.load = bench::Load::words();
  }
  const Nanoseconds stolen = os::stolen_time();
  Progress progress;
  auto sections = benchmark(with_progress(options.settings, progress), report.refused);
  progress.clear();
  if (!sections) {
    complain(sections.problems());
    return 1;
  }
  report.stolen = os::stolen_time() - stolen;
  report.sections = std::move(*sections);
  return print(options.json ? model::json_text(bench::report_json(report)) + "\n"
                            : bench::report_text(report))
             ? 0
             : 1;
}

}  // namespace

void add_bench(CLI::App& app, Chosen& chosen) {
  auto* bench = app.add_subcommand("bench", "Measure Takt on this machine and compare it with a reference");
  bench->require_subcommand(1);
  const auto add = [&](const char* name, const char* what,
                       const std::function<int(const BenchOptions&)>& run) {
    auto options = std::make_shared<BenchOptions>();
    auto* command = bench->add_subcommand(name, what);
    command->add_option("--for", options->settings.seconds, "duration of each measurement")
        ->type_name("SECONDS")
        ->check(within(0.01, 86400.0));
    command
        ->add_option("--cpu", options->settings.cpu,
                     "the CPU on which the real-time threads run (default: the last one)")
        ->type_name("N")
        ->check(CLI::Range(0, 1023).description(""));
    command->add_flag("--load", options->settings.load,
                      "load all CPUs with stress-ng during the measurement");
    command->add_flag("--json", options->json, "print one JSON object");
    command->callback([options, run, &chosen] {
      chosen = [options, run] {
        if (options->period_us) {
          options->settings.period = std::chrono::duration_cast<Nanoseconds>(
              std::chrono::duration<double, std::micro>(*options->period_us));
        }
        const auto domain =
            client::domain_of({.domain = options->settings.domain, .peers = "", .server = ""});
        if (!domain) {
          complain(domain.problems());
          return 1;
        }
        options->settings.domain = *domain;
        const std::vector<int> cpus = os::read_cpus().permitted;
        if (const auto& cpu = options->settings.cpu;
            cpu && std::find(cpus.begin(), cpus.end(), *cpu) == cpus.end()) {
          complain({{"--cpu", fmt::format("takt may not run on CPU {}", *cpu),
                     "choose one of the CPUs " + model::cpus_text(cpus)}});
          return 1;
        }
        return run(*options);
      };
    });
    return std::pair{command, options};
  };
  const auto add_measure = [&](const char* name, const char* what, Benchmark benchmark) {
    return add(name, what,
               [name, benchmark](const BenchOptions& options) { return measure(name, benchmark, options); });
  };
  const auto with_period = [](const auto& added) {
    added.first
        ->add_option("--period", added.second->period_us,
                     "use this period instead of the benchmark's default period")
        ->type_name("MICROSECONDS")
        ->check(within(20.0, 1e6));
  };
  const auto with_domain = [](const auto& added) {
    added.first
        ->add_option("--domain", added.second->settings.domain,
                     "the DDS domain of the nodes that the benchmark starts")
        ->type_name("N")
        ->check(CLI::Range(0, 232).description(""));
  };

  const auto cases = add(
      "table1", "Measure the ten cases of the paper's Table 1, in nodes and hosts as `takt run` starts them",
      table1);
  with_period(cases);
  with_domain(cases);
  cases.first
      ->add_option("--html", cases.second->html,
                   "write an HTML page with the table, the jitter over time and histograms")
      ->type_name("OUT");
  add_measure("dispatch",
              "Measure the cost of calling 1000 modules from a table, compared with waking 1000 threads",
              bench::dispatch);
  with_period(add_measure("wake", "Measure how punctually an executor wakes up, with each wake-up strategy",
                          bench::wake));
  const auto process =
      add_measure("process", "Measure the time from the release of a process module to the start of its body",
                  bench::process);
  with_period(process);
  with_domain(process);
  add_measure("ports", "Measure the time to transfer a sample from one port to another", bench::ports);

  const auto cell = add_measure("cell",
                                "Measure the deployment of a cell of several devices on this machine, and "
                                "the transfer of samples between the devices",
                                bench::cell);
  with_period(cell);
  with_domain(cell);
  cell.first
      ->add_option("--devices", cell.second->settings.cell.devices,
                   "the number of devices, each with its own node")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(2, 64).description(""));
  cell.first
      ->add_option("--pairs", cell.second->settings.cell.pairs,
                   "the number of module pairs on each device: one module sends, the other receives")
      ->type_name("N")
      ->capture_default_str()
      ->check(CLI::Range(1, 100).description(""));

  // Hidden commands: takt bench starts them as the second process of some measurements.
  bench->add_subcommand("peer")->group("")->callback([&chosen] { chosen = bench::serve_as_peer; });
  bench->add_subcommand("writer")->group("")->callback([&chosen] { chosen = bench::serve_as_writer; });
}

}  // namespace takt::tool
