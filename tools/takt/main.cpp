// The command line.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include <takt/core/words.hpp>

#include "commands.hpp"
#include "pages.hpp"
#include "ranges.hpp"
#include "signatures.hpp"

namespace {

// CLI::PositiveNumber takes inf, and says its range with 308 digits.
std::string positive_seconds(const std::string& text) {
  constexpr double kLongest = 1e9;
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  const bool number = end != text.c_str() && *end == '\0';
  return number && value > 0 && value <= kLongest
             ? ""
             : "'" + text + "' is no number of seconds above 0 and up to 1e9";
}

int run_program(int argc, char** argv) {
  using namespace takt::tool;
  CLI::App app{"Takt: real-time component middleware for industrial cells.", "takt"};
  app.set_version_flag("--version", TAKT_VERSION);
  app.require_subcommand(1);
  app.footer(R"(
Environment:
  TAKT_COMPONENT_PATH         folders, separated by ':', where the files of components are looked up after the
                              descriptor's own and before the ready components
  TAKT_DOMAIN                 the DDS domain where no --domain is given
  TAKT_INTERFACE              addresses, separated by ',', of the network cards that are used; all unless set
  TAKT_SECURITY               the folder of takt secure that says who this is, where no --security is given
  TAKT_SIGNED_BY              a certificate: components are used only if they are signed with its key
  TAKT_STATE_DIR              where takt-node keeps what it is to resume, and its fault record
  NO_COLOR                    no colours

Status: 0 done, 1 refused or failed with the reason on standard error, 2 wrong usage.)");

  CheckOptions check_options;
  auto* check_command =
      app.add_subcommand("check", "Validate a descriptor and print its tables; start nothing");
  check_command->add_option("FILE", check_options.file, "a cell, or a module.xml")->required();
  check_command->add_flag("--json", check_options.json, "print one JSON object");
  check_command->add_option("--svg", check_options.svg, "write the tables as a picture to this file")
      ->type_name("OUT");
  check_command->add_flag("--expanded", check_options.expanded,
                          "print the descriptor as it is without includes and templates, and no tables");
  check_command->add_flag("--remote", check_options.remote,
                          "a component that is not on this machine is a warning, no error");
  check_command
      ->add_option("--profile", check_options.proof.profile,
                   "say whether every deadline is kept, with the run times that takt run --profile wrote")
      ->type_name("FILE");
  check_command
      ->add_option(
          "--factor", check_options.proof.factor,
          "the longest run is this much longer than the file, or the budget, says: 1 (unless given) to "
          "1000")
      ->type_name("X")
      ->check(within(1, 1000));
  check_command
      ->add_option("--cpus", check_options.proof.processors,
                   "a device has this many processors (else as many as this machine)")
      ->type_name("N")
      ->check(CLI::Range(1, 1024).description(""));

  Chosen chosen;
  add_graph(app, chosen);

  RunOptions run_options;
  double seconds = 0;
  auto* run_command = app.add_subcommand(
      "run", "Run a descriptor on this machine, one takt-node for each device, until Ctrl-C");
  run_command->add_option("FILE", run_options.file, "a cell, or a module.xml")->required();
  auto* for_option = run_command->add_option("--for", seconds, "end after this long")
                         ->type_name("SECONDS")
                         ->check(positive_seconds);
  run_command->add_flag("--json", run_options.json, "print the closing report as one JSON object");
  run_command->add_flag("--require-realtime", run_options.require_real_time,
                        "refuse to run where the system refuses real-time scheduling");
  run_command
      ->add_option("--profile", run_options.profile, "write how long each module ran to this file at the end")
      ->type_name("OUT");
  run_command
      ->add_option("--state-dir", run_options.state_folder,
                   "where the fault record of each device is kept; without it they go with the run")
      ->type_name("DIR");
  run_command->add_flag("--check-realtime", run_options.check_real_time,
                        "name every allocation, lock, system call and page fault in a module's run() or "
                        "condition(), with the calls that led there; status 1 if there were any. Slower");
  run_command->add_flag("--quiet", run_options.quiet, "no line for each event, only the closing report");
  add_network_options(*run_command, run_options.network);

  add_new(app, chosen);
  add_simulate(app, chosen);
  add_deploy(app, chosen);
  add_undeploy(app, chosen);
  add_status(app, chosen);
  add_watch(app, chosen);
  add_web(app, chosen);
  add_log(app, chosen);
  add_orders(app, chosen);
  add_swap(app, chosen);
  add_properties(app, chosen);
  add_echo(app, chosen);
  add_record(app, chosen);
  add_play(app, chosen);
  add_plot(app, chosen);
  add_trace(app, chosen);
  add_call(app, chosen);
  add_doctor(app, chosen);
  add_secure(app, chosen);
  add_sign(app, chosen);
  add_bench(app, chosen);
  add_describe(app, chosen);

  tidy_help(app);
  shorten_errors(app);
  if (argc == 3 && std::string_view{argv[1]} == kWritePages) return write_pages(app, argv[2], 1);

  const auto is_meant = [&](const CLI::App* command) { return command->get_name() == argv[1]; };
  if (argc > 1 && argv[1][0] != '-' && app.get_subcommands(is_meant).empty()) {
    std::vector<std::string> names;
    for (const CLI::App* command : app.get_subcommands({})) names.push_back(command->get_name());
    const std::string_view meant = takt::nearest(argv[1], {names.begin(), names.end()});
    const std::string wrong = "takt: there is no command " + takt::in_quotes(argv[1]);
    if (meant.empty())
      std::fprintf(stderr, "%s\n\n%s", wrong.c_str(), app.help().c_str());
    else
      std::fprintf(stderr, "%s; did you mean %s?\n", wrong.c_str(), std::string{meant}.c_str());
    return 2;
  }
  require_signatures();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (for_option->count() != 0) run_options.seconds = seconds;
  if (chosen) return chosen();
  if (*check_command) return check(check_options);
  return run(run_options);
}

}  // namespace

int main(int argc, char** argv) {
  const int status = run_program(argc, argv);
  // Not by way of the static objects of Fast DDS, which sleep for a while in their destructors.
  std::fflush(nullptr);
  std::_Exit(status);
}
