// takt simulate: runs a whole cell on virtual time, in a single process.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <takt/client/connection.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/files.hpp>
#include <takt/os/output_file.hpp>
#include <takt/schedule/longest_runs.hpp>
#include <takt/simulation/random_cell.hpp>
#include <takt/simulation/simulation.hpp>

#include "commands/commands.hpp"
#include "commands/load.hpp"
#include "commands/proof.hpp"
#include "commands/ranges.hpp"
#include "reports/run_report.hpp"
#include "terminal/progress.hpp"
#include "terminal/screen_style.hpp"
#include "terminal/terminal.hpp"

namespace takt::tool {

namespace {

/// The maximum size of a script, in bytes.
constexpr std::size_t kMostScript = std::size_t{16} * 1024 * 1024;

struct SimulateOptions {
  std::string file;
  double seconds = 10;
  std::uint64_t seed = 1;
  std::string script;
  std::string update;
  std::string profile;
  double faults = 0;
  int cpus = 0;
  std::string trace;
  bool json = false;
  std::uint64_t random_cell = 0;
  bool is_random = false;
};

/// Writes the trace of a simulation: one line for each event.
class Trace final : public simulation::Listener {
 public:
  Trace(os::OutputFile file, const model::Cell& cell, const simulation::Version* update)
      : file_(std::move(file)), cell_(cell), update_(update) {}

  void on_event(const simulation::Event& event) override {
    const model::Cell& cell = event.version == 0 ? cell_ : update_->cell;
    file_.write(simulation::to_text(event, cell, simulation::kT0) + '\n');
  }
  Result<void> close() { return file_.close(); }

 private:
  os::OutputFile file_;
  const model::Cell& cell_;
  const simulation::Version* update_;
};

int show_simulation(const SimulateOptions& options, const model::Cell& cell,
                    const std::vector<schedule::DevicePlan>& plans, const model::CellPorts& ports,
                    simulation::Options simulated) {
  std::optional<Trace> trace;
  if (!options.trace.empty()) {
    auto file = os::OutputFile::open_or_standard(options.trace);
    if (!file) {
      complain(file.problems());
      return 1;
    }
    simulated.listener = &trace.emplace(std::move(*file), cell, simulated.update);
  }
  const Instant begun = os::now();
  Progress progress;
  if (progress.is_seen()) {
    simulated.progress = [&](Nanoseconds passed) {
      if (!progress.is_due()) return;
      const double seconds = std::chrono::duration<double>(passed).count();
      const double length = std::chrono::duration<double>(simulated.length).count();
      const double took = std::chrono::duration<double>(os::now() - begun).count();
      progress.show(share_text(
          seconds / length,
          fmt::format("{:.1f} of {:g} s simulated, {:.0f} times real time", seconds, length, seconds / took),
          {.unicode = is_utf8()}));
    };
  }
  const auto course = simulation::simulate(cell, plans, ports, simulated);
  const std::chrono::duration<double> took = os::now() - begun;
  progress.clear();
  if (!course) {
    complain(course.problems());
    return 1;
  }
  if (trace) {
    if (const auto written = trace->close(); !written) {
      complain(written.problems());
      return 1;
    }
  }
  auto report = course->report;
  for (const simulation::Report& action : course->reports) report["operator"].push_back(to_text(action));
  const bool printed = print(options.json ? model::json_text(report) + "\n" : run_text(report));
  const double simulated_s = std::chrono::duration<double>(simulated.length).count();
  std::fprintf(stderr, "takt: simulated %g s in %.3f s, %.0f times real time; seed %llu\n", simulated_s,
               took.count(), simulated_s / took.count(), static_cast<unsigned long long>(simulated.seed));
  if (!cell.connections.empty()) {
    std::fprintf(stderr,
                 "takt: the components are not called; every module writes each of its outputs in every run, "
                 "so a queue may drop samples that the components would not write\n");
  }
  for (const std::string& fault : course->without_effect) tell("takt: warning: " + fault);
  bool all_done = true;
  for (const simulation::Report& action : course->reports) {
    all_done &= action.outcome == simulation::Outcome::done;
    tell("takt: operator: " + to_text(action));
  }
  if (!course->failures.empty()) complain(course->failures);
  for (const std::string& violation : course->violations)
    tell("takt: error: the simulation violated an invariant: " + violation);
  return course->failures.empty() && course->violations.empty() && all_done && printed ? 0 : 1;
}

/// Describes a random cell as text, because it has no descriptor.
std::string words_of(const simulation::RandomCell& random) {
  const model::Cell& cell = random.cell;
  std::string text;
  for (const model::Device& device : cell.devices) {
    for (const model::Executor& executor : device.executors) {
      text += fmt::format("# {}.{}: executor, priority {}{}\n", device.name, executor.name, executor.priority,
                          executor.cpu ? fmt::format(", cpu {}", *executor.cpu) : "");
    }
    for (const model::Module& m : device.modules) {
      text += fmt::format("# {}.{}: {} {}{}{}{}{}, priority {}{}\n", device.name, m.name,
                          to_text(m.operation), to_text(m.type), m.period ? " of " + to_text(*m.period) : "",
                          m.deadline ? ", deadline " + to_text(*m.deadline) : "",
                          m.dispatch == model::Dispatch::immediate ? ", immediate" : "",
                          m.interarrival ? ", interarrival " + to_text(*m.interarrival) : "", m.priority,
                          m.executor.empty() ? "" : ", executor " + m.executor);
    }
  }
  for (const model::Connection& connection : cell.connections) {
    text += fmt::format("# {} to {}: {} of {}{}{}\n", to_text(connection.from), to_text(connection.to),
                        to_text(connection.kind), connection.depth,
                        connection.deadline ? ", deadline " + to_text(*connection.deadline) : "",
                        connection.stale == model::Stale::error ? ", a stale value is an error" : "");
  }
  return text + fmt::format("# {} faults per second for {}, {} CPUs per device\n",
                            random.options.faults_per_second, to_text(random.options.length),
                            random.options.cpus);
}

/// The names of the real-time modules without a budget, as a list.
std::string without_budget(const model::Cell& cell) {
  std::string names;
  for (const model::Device& device : cell.devices) {
    for (const model::Module& m : device.modules) {
      if (m.budget || m.operation == model::Operation::non_real) continue;
      names += (names.empty() ? "" : ", ") + device.name + "." + m.name;
    }
  }
  return names;
}

/// Warns of each fault and command of the script that has no effect.
void warn_of_no_effect(const simulation::Options& simulated, const model::Cell& cell) {
  for (const simulation::Injection& one : simulated.injections) {
    const model::Device& device = cell.devices[one.device];
    const char* why = nullptr;
    if (one.at >= simulated.length)
      why = "the simulation ends before; use a longer --for";
    else if (one.kind == simulation::Injection::Kind::swap &&
             device.modules[one.target].type == model::ModuleType::process)
      why = "the module is a program, and only a thread module can be swapped";
    if (why != nullptr) tell("takt: warning: '" + to_text(one, cell) + "' has no effect: " + why);
  }
}

int simulate(const SimulateOptions& options) {
  if (options.is_random) {
    const simulation::RandomCell random = simulation::random_cell(options.random_cell);
    if (!options.json && !print(words_of(random))) return 1;
    return show_simulation(options, random.cell, random.plans, {}, random.options);
  }
  Problems missing;  // ignored, because a simulation does not need the components
  const auto loaded = load(options.file, &missing);
  if (!loaded) {
    complain(loaded.problems());
    return 1;
  }
  simulation::Options simulated;
  simulated.seed = options.seed;
  simulated.length = std::chrono::duration_cast<Nanoseconds>(std::chrono::duration<double>(options.seconds));
  simulated.faults_per_second = options.faults;
  simulated.cpus = options.cpus;
  if (!options.profile.empty()) {
    auto profile = read_profile(options.profile);
    if (!profile) {
      complain(profile.problems());
      return 1;
    }
    // Reject an incomplete profile, as `takt check` does, instead of guessing the missing run times.
    if (const auto runs = schedule::longest_runs(loaded->cell, &*profile, 1); !runs) {
      complain(runs.problems());
      return 1;
    }
    simulated.profile = std::move(*profile);
  }
  if (!options.script.empty()) {
    const auto text = os::read_file(options.script, kMostScript);
    if (!text || !*text) {
      complain(text ? Problems{{options.script, "there is no such file",
                                "give a script with one fault per line; see takt simulate --help"}}
                    : text.problems());
      return 1;
    }
    auto faults = simulation::parse_script(**text, options.script, loaded->cell);
    if (!faults) {
      complain(faults.problems());
      return 1;
    }
    simulated.injections = std::move(*faults);
    warn_of_no_effect(simulated, loaded->cell);
  }
  std::optional<simulation::Version> update;
  if (!options.update.empty()) {
    const auto loaded_update = load(options.update, &missing);
    if (!loaded_update) {
      complain(loaded_update.problems());
      return 1;
    }
    update = {.cell = loaded_update->cell, .plans = loaded_update->plans, .ports = loaded_update->ports};
    simulated.update = &*update;
  }
  const auto& injections = simulated.injections;
  const auto updates = [](const auto& one) { return one.kind == simulation::Injection::Kind::update; };
  if (update && std::none_of(injections.begin(), injections.end(), updates))
    std::fprintf(stderr,
                 "takt: warning: --update has no effect: the script has no line such as 'at 2 s update'\n");
  if (!update && std::any_of(injections.begin(), injections.end(), updates)) {
    complain({{options.script, "the script updates the cell, but no new descriptor is given",
               "give it with --update FILE"}});
    return 1;
  }
  if (const std::string guessed = without_budget(loaded->cell); options.profile.empty() && !guessed.empty()) {
    std::fprintf(
        stderr,
        "takt: warning: the run times of these modules are not known: %s; each module is assumed to take 5 "
        "%% of its period or deadline; give them a <budget>, or measure them with takt run --profile\n",
        guessed.c_str());
  }
  return show_simulation(options, loaded->cell, loaded->plans, loaded->ports, std::move(simulated));
}

}  // namespace

void add_simulate(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<SimulateOptions>();
  auto* command = app.add_subcommand(
      "simulate",
      "Simulate a cell on virtual time: the whole cell runs in one process, faster than real time");
  auto* file = command->add_option("FILE", options->file,
                                   "a cell, or a module.xml; the simulation does not call components");
  auto* length =
      command
          ->add_option("--for", options->seconds, "simulated time from the first row to the end (default 10)")
          ->type_name("SECONDS")
          ->check(within(1e-6, 1e6, "a number of seconds"));
  auto* seed =
      command
          ->add_option("--seed", options->seed,
                       "the seed of the random numbers; the same seed gives the same trace (default 1)")
          ->type_name("N")
          ->check(whole_number());
  auto* script = command
                     ->add_option("--script", options->script,
                                  "a script with the faults to inject, one per line; see below")
                     ->type_name("FILE");
  auto* update =
      command
          ->add_option("--update", options->update, "the new descriptor to which the script updates the cell")
          ->type_name("FILE");
  auto* profile =
      command
          ->add_option(
              "--profile", options->profile,
              "take the run times from this file, which takt run --profile wrote (default: from the budgets)")
          ->type_name("FILE");
  auto* faults = command->add_option("--faults", options->faults, "add this many random faults per second")
                     ->type_name("PER_SECOND")
                     ->check(within(0.0, 1e5));
  auto* cpus =
      command
          ->add_option("--cpus", options->cpus,
                       "the number of CPUs of each device, which executors without a cpu attribute share")
          ->type_name("N")
          ->check(CLI::Range(1, 1024).description(""));
  command
      ->add_option("--trace", options->trace,
                   "write every event to this file, one per line; - for standard output")
      ->type_name("FILE");
  auto* json = command->add_flag("--json", options->json, "print the closing report as one JSON object");
  auto* random = command
                     ->add_option("--random-cell", options->random_cell,
                                  "simulate the random cell number N instead of FILE (for tests)")
                     ->type_name("N")
                     ->check(whole_number())
                     ->excludes(file);
  // The number of the random cell also determines the values of these options.
  for (auto* fixed : {length, seed, script, update, profile, faults, cpus}) random->excludes(fixed);
  command->footer(
      "Exit status: 0 the cell ended cleanly; 1 a module or device was given up, an action of the operator\n"
      "failed, or an invariant was violated. An invariant is a rule that must hold whatever faults occur. A "
      "run of a module without a\n"
      "budget and without a run time in the profile takes 5 % of the module's period or deadline.\n\n"
      "A script; times count from the first row, in ns, us, ms or s:\n" +
      simulation::script_help());
  command->callback([options, file, random, json, &chosen] {
    if (file->count() == 0 && random->count() == 0) throw CLI::RequiredError("FILE");
    if (options->trace == "-" && json->count() != 0)
      throw CLI::ValidationError("--trace", "- and --json both need standard output");
    options->is_random = random->count() != 0;
    chosen = [options] { return simulate(*options); };
  });
}

}  // namespace takt::tool
