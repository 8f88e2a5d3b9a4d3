// takt bench: how fast and how punctual Takt is on this machine, each time beside what it is measured
// against.
#include <fstream>
#include <memory>

#include "bench/settings.hpp"
#include "bench/table1.hpp"
#include "bench/table1_report.hpp"
#include "commands.hpp"
#include "load.hpp"
#include "terminal.hpp"

namespace takt::tool {

namespace {

struct BenchOptions {
  bench::Settings settings;
  double period_us = 0;
  bool json = false;
  std::string html;
};

int table1(const BenchOptions& options) {
  const auto say = [&options](const std::string& text) {
    if (!options.json) print(text);
  };
  const auto result = bench::run_table1(options.settings, [&](const bench::Table1Result& so_far) {
    say(so_far.cases.empty() ? bench::table1_head(so_far) : bench::table1_rows(so_far.cases.back(), so_far));
  });
  if (!result) {
    complain(result.problems());
    return 1;
  }
  say(bench::table1_foot());
  return options.json && !print(bench::table1_json(*result).dump() + "\n") ? 1 : 0;
}

}  // namespace

void add_bench(CLI::App& app, Chosen& chosen) {
  auto* bench =
      app.add_subcommand("bench", "Measure Takt on this machine, beside what it is measured against");
  bench->require_subcommand(1);
  auto options = std::make_shared<BenchOptions>();
  auto* command = bench->add_subcommand("table1", "the ten cases of the paper's Table 1");
  command->add_option("--for", options->settings.seconds, "of each case");
  command->add_flag("--json", options->json, "print one JSON object");
  command->callback([options, &chosen] { chosen = [options] { return table1(*options); }; });
}

}  // namespace takt::tool
